#pragma once

// Filter functions for Embree: they apply the tie rule (see kCoplanar) and reject hits at transparent texels.

#include <cstdint>

#include "methods/world/resolve.h"
#include "methods/world/world.h"
#include "scene/embree.h"

namespace scanmill {

// Returns the triangle with these ids of Embree. `instance`: RTC_INVALID_GEOMETRY_ID for a baked triangle.
inline HitTriangle hitTriangle(const World& world, std::uint32_t instance, std::uint32_t geometry,
                               std::uint32_t primitive) {
  const PlacedBlock* placed =
      instance == RTC_INVALID_GEOMETRY_ID ? nullptr : &world.placed[instance - World::kFirstPlaced];
  const TriangleBlock* block = placed == nullptr ? &world.baked : placed->block;
  return {block, placed, block->indexOf(geometry, primitive)};
}

// Returns the instance id of a triangle's object.
inline std::uint32_t instanceOf(const HitTriangle& hit) {
  const std::uint32_t object = hit.block->surfaceOf(hit.index).instance;
  return hit.placed == nullptr ? object : instanceId(hit.placed->firstInstanceId, object);
}

// The nearest hit so far of each ray of a packet, while Embree traces the packet. Lane i has the ray with the id i.
struct TieContext {
  EmbreeContext embree = newEmbreeContext();
  const World* world;
  float floor;                          // m, result of coplanarFloor(): part of the tolerance of coplanar surfaces
  alignas(64) float distance[kPacket];  // m, distance to the nearest surface; infinite: no hit yet
  alignas(64) std::uint32_t geometry[kPacket];
  alignas(64) std::uint32_t primitive[kPacket];
  alignas(64) std::uint32_t instance[kPacket];

  void reset();
};

// Surfaces are treated as coplanar if the gap between them, along their normals, is at most kCoplanar times the
// distance from the ray's origin, plus the floor. Of coplanar surfaces, the surface with the lowest instance id is hit;
// if ids are equal, the first instance of the scene, then opaque before alpha-tested triangles, then the first triangle
// of the mesh. The order of the traversal therefore does not matter. The tolerance covers float32 rounding of
// distances, and of corners near the sensor.
constexpr float kCoplanar = 4e-7f;
constexpr float kCoplanarCorners = 64;  // m; the floor covers rounding of corners up to this far from the sensor

// Returns the floor of the tolerance (m). `sensorToOrigin`: distance of the sensor from the world's origin (m).
inline float coplanarFloor(float sensorToOrigin) {
  constexpr float kRounding = 2.5e-7f;  // about four times the relative rounding error of float32, 2^-24
  return kRounding * (sensorToOrigin + kCoplanarCorners);
}

// An accepted hit shortens the ray to the hit's distance, plus this fraction of the distance, plus the floor, so that
// Embree visits coplanar surfaces too. The fraction suffices for angles of incidence up to 89.98 degrees.
constexpr float kReach = 1e-3f;

// The filters for opaque and for alpha-tested triangles. Both expect a TieContext as context.
void tieFilter(const RTCFilterFunctionNArguments* arguments);
void alphaTieFilter(const RTCFilterFunctionNArguments* arguments);

}  // namespace scanmill
