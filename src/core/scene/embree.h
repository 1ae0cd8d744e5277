#pragma once

// Embree 3.13 (Debian 12) or 4 (Debian 13, Ubuntu 24.04): the versions differ in how a query is passed its context. All
// code that depends on the version is in this file.

#if SCANMILL_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace scanmill {

// A query passes the address of its context to its filter functions. A struct with more data for a filter has the
// context as its first member, so that the filter can cast that address to the struct.
#if SCANMILL_EMBREE_MAJOR >= 4
using EmbreeContext = RTCRayQueryContext;
#else
using EmbreeContext = RTCIntersectContext;
#endif

inline EmbreeContext newEmbreeContext() {
  EmbreeContext context;
#if SCANMILL_EMBREE_MAJOR >= 4
  rtcInitRayQueryContext(&context);
#else
  rtcInitIntersectContext(&context);
#endif
  return context;
}

// Finds the nearest hit of a ray. Hits that the filter function of a geometry rejects do not count.
inline void intersectOne(RTCScene scene, EmbreeContext& context, RTCRayHit& ray) {
#if SCANMILL_EMBREE_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context;
  rtcIntersect1(scene, &ray, &arguments);
#else
  rtcIntersect1(scene, &context, &ray);
#endif
}

// Does the same as intersectOne() for sixteen coherent rays. `valid` is -1 for each active ray, else 0.
inline void intersectPacket(RTCScene scene, EmbreeContext& context, const int* valid, RTCRayHit16& rays) {
#if SCANMILL_EMBREE_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context;
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect16(valid, scene, &rays, &arguments);
#else
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect16(valid, scene, &context, &rays);
#endif
}

// Sets the ray's far end to minus infinity if the ray has any hit that counts for intersectOne().
inline void occludeOne(RTCScene scene, EmbreeContext& context, RTCRay& ray) {
#if SCANMILL_EMBREE_MAJOR >= 4
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &context;
  rtcOccluded1(scene, &ray, &arguments);
#else
  rtcOccluded1(scene, &context, &ray);
#endif
}

}  // namespace scanmill
