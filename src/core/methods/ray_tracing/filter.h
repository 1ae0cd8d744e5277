#pragma once

// Embree's intersection filters, which apply the tie rule and alpha-tested textures.

#include <cstdint>

#include "methods/world/resolve.h"
#include "methods/world/world.h"
#include "scene/embree.h"

namespace scanmill {

// The state of a packet while Embree traces it: the nearest hit of each ray so far. Lane i belongs to the ray whose id
// is i.
struct TieContext {
  EmbreeContext embree = newEmbreeContext();
  const World* world;
  float floor;                          // m, see coplanarFloor()
  alignas(64) float distance[kPacket];  // to the nearest surface; infinite: nothing was hit
  alignas(64) std::uint32_t geometry[kPacket];
  alignas(64) std::uint32_t primitive[kPacket];
  alignas(64) std::uint32_t instance[kPacket];

  void reset();
};

// Surfaces count as coplanar if they lie within kCoplanar x distance + floor of each other, measured along their
// normals. Among coplanar surfaces the lowest instance id wins, then the lowest Embree instance, geometry and
// primitive, whatever order the traversal visits them in. The tolerance covers float32 rounding, of distances and of
// corners near the sensor.
constexpr float kCoplanar = 4e-7f;
constexpr float kCoplanarCorners = 64;  // m, largest distance of a near corner from the sensor

inline float coplanarFloor(float sensorToOrigin) {
  return 2.5e-7f * (sensorToOrigin + kCoplanarCorners);
}

// When a hit is accepted, the ray is cut off not at the hit but farther, by this share of the hit's distance, so that
// surfaces coplanar with the hit are visited too, in any order. The margin suffices up to 89.98 degrees of incidence.
constexpr float kReach = 1e-3f;

void tieFilter(const RTCFilterFunctionNArguments* arguments);
void alphaTieFilter(const RTCFilterFunctionNArguments* arguments);

}  // namespace scanmill
