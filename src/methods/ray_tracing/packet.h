#pragma once

// One packet of beams: set up in double, traced by Embree in float32, resolved in double.

#include <cstdint>
#include <span>
#include <vector>

#include "methods/ray_tracing/filter.h"
#include "methods/ray_tracing/world.h"
#include "scan/hits.h"
#include "sensors/shot.h"

namespace scanmill {

// What resolving needs of a material, without its texts.
struct CompactMaterial {
  float reflectance = 0;
  float textureGain = 0;             // reflectance / mean luminance of the texture; 0 where untextured
  const Texture* texture = nullptr;  // only where textured
};

// A shot's poses, relative to the world's origin.
struct ShotFrame {
  std::vector<Mat3> rotation;  // per step
  std::vector<Vec3d> position;
};

struct PacketJob {
  const World& world;
  const std::vector<CompactMaterial>& materials;
  const Shot& shot;
  const ShotFrame& frame;
  int raysPerCall;
  float coplanarFloor;  // m
};

// A rectangle of at most 16 beams: rings [ring, ring + rows) x columns [column, column + width).
struct Tile {
  std::uint32_t ring, column, rows, width;
};

void tracePackets(const PacketJob& job, std::span<const Tile> tiles, Hits& hits);

}  // namespace scanmill
