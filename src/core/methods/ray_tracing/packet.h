#pragma once

// One packet of beams: set up in double, traced by Embree in float32, resolved in double.

#include <cstdint>
#include <span>
#include <vector>

#include "methods/ray_tracing/filter.h"
#include "methods/world/resolve.h"
#include "methods/world/world.h"
#include "scan/hits.h"
#include "sensors/shot.h"

namespace scanmill {

struct PacketJob {
  const World& world;
  const std::vector<CompactMaterial>& materials;
  const Shot& shot;
  const ShotFrame& frame;
  int raysPerCall;
  float coplanarFloor;  // m
};

// How far rays are traced (m): a little past the maximum range, since a distance in float32 must not decide what lies
// at exactly the maximum.
float searchDistance(const BeamTable& beams);

void tracePackets(const PacketJob& job, std::span<const Tile> tiles, Hits& hits);

}  // namespace scanmill
