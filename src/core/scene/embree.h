#pragma once

// Embree 3.13 (Debian 12) and 4 (Debian 13, Ubuntu 24.04) pass the context of a query in different ways. All code that
// depends on the version is in this file.

#if SCANMILL_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <cmath>
#include <initializer_list>

#include "base/vec.h"

namespace scanmill {

// Embree passes the address of a query's context to filter functions. A struct with further data for a filter must have
// the context as its first member, so that the filter can cast this address to the struct.
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

// Returns a component of a direction for Embree; tiny components become 0. Embree 3.13 treats components with absolute
// values below 1e-18 as positive when it divides by them, but not when it tests their sign: with -4e-19 in one lane,
// all rays of a coherent packet missed surfaces that they should have hit.
inline float nonTiny(double direction) {
  constexpr double kAlongAnAxis = 1e-12;
  return static_cast<float>(std::abs(direction) < kAlongAnAxis ? 0.0 : direction);
}

// Returns a query for hits at distances from `near` to `far` (m) along a ray. `time`: 0 to 1, for moving instances.
inline RTCRayHit newRay(const Vec3d& origin, const Vec3d& direction, float near, float far, float time = 0) {
  RTCRayHit query;
  query.ray = {.org_x = static_cast<float>(origin.x),
               .org_y = static_cast<float>(origin.y),
               .org_z = static_cast<float>(origin.z),
               .tnear = near,
               .dir_x = static_cast<float>(direction.x),
               .dir_y = static_cast<float>(direction.y),
               .dir_z = static_cast<float>(direction.z),
               .time = time,
               .tfar = far,
               .mask = ~0u,
               .id = 0,
               .flags = 0};
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return query;
}

// Adds an instance of the scene `mesh` to a scene. `sceneFromMesh`: one transform or, if the instance moves, the two
// transforms at the ray times 0 and 1.
inline void attachInstance(RTCDevice device, RTCScene scene, RTCScene mesh, std::initializer_list<Affine> sceneFromMesh,
                           unsigned id) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, mesh);
  rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(sceneFromMesh.size()));
  for (unsigned step = 0; const Affine& a : sceneFromMesh) {
    float columns[12];
    int k = 0;
    for (const Vec3d& column : {a.linear.x, a.linear.y, a.linear.z, a.translation}) {
      for (const double value : {column.x, column.y, column.z}) columns[k++] = static_cast<float>(value);
    }
    rtcSetGeometryTransform(geometry, step++, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

// Stores the nearest hit of a ray in `ray`. Hits that the filter function of a geometry rejects do not count.
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

// Finds the nearest hits of sixteen coherent rays, as intersectOne() does. `valid` is -1 for each active ray, else 0.
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

// Sets the far ends of those of sixteen rays that hit anything to minus infinity; as in intersectOne(), rejected hits
// do not count. `valid` is as for intersectPacket(). With the flag for coherent rays Embree 3.13 did not return.
inline void occludePacket(RTCScene scene, EmbreeContext& context, const int* valid, RTCRay16& rays) {
#if SCANMILL_EMBREE_MAJOR >= 4
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &context;
  rtcOccluded16(valid, scene, &rays, &arguments);
#else
  rtcOccluded16(valid, scene, &context, &rays);
#endif
}

}  // namespace scanmill
