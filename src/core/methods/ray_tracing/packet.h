#pragma once

// Traces packets of beams, which are set up in double, traced by Embree in float32, and resolved in double.

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
  float coplanarFloor;  // m, see coplanarFloor()
};

// Returns a distance (m) from the shot's first position within which all rays of the shot end. If a ray starts more
// than 1 m from the sensor's origin, the rays are taken for continuations of earlier rays behind a pane or mirror: each
// then ends at its Shot::blockedBeyond, if the shot has this array.
double farthestEnd(const Shot& shot);
// Returns a distance like farthestEnd(shot), but for any rays that start within `farthestOrigin` (m) of the sensor.
double farthestEnd(const Shot& shot, double farthestOrigin);

void tracePackets(const PacketJob& job, std::span<const Tile> tiles, Hits& hits);

}  // namespace scanmill
