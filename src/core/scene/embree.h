#pragma once

// Embree 3.13 (Debian 12) or 4 (Debian 13, Ubuntu 24.04): the versions differ in how a query is passed its context. All
// that differs between them stands here.

#if SCANMILL_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace scanmill {

// A query and its filter functions share the context. A filter gets its address, so that a struct which holds more for
// the filter has the context as its first member.
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

// Finds the first surface that the ray meets, or those that a filter function lets pass.
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

// The same for sixteen rays that stay close to each other. `valid` is -1 for each ray that counts, else 0.
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

// Sets the ray's far end to minus infinity where it meets any surface.
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
