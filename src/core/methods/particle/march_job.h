#pragma once

// Turns beams into particles, and the particles' results into hits.

#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "methods/field/distance_field.h"
#include "methods/field/particle_launch.h"
#include "methods/particle/march.h"
#include "methods/world/resolve.h"
#include "methods/world/world.h"
#include "scan/hits.h"
#include "sensors/shot.h"

namespace scanmill {

// A shot and the field through which its particles march.
struct MarchJob {
  const Shot& shot;
  const World& world;
  const DistanceField& field;
  const ShotFrame& frame;  // the shot's poses, relative to the world's origin
  std::uint32_t steps;     // largest number of steps of a particle
  Box box;                 // m, relative to the world's origin: particles march only inside of the box
  bool whole;              // true if the box contains the complete scene
};

// Numbers of beams that are neither hit nor miss, or whose hit is unreliable.
struct MarchCounts {
  std::uint64_t exhausted = 0;  // beams whose particles used up all their steps
  std::uint64_t left = 0;       // beams whose particles left the field, which does not cover the complete scene
  std::uint64_t touching = 0;   // beams whose particles started so near to a surface that they hit it at once
  MarchCounts& operator+=(const MarchCounts& o);
};

// Returns the length of particles' paths (m): slightly more than the sensor's maximum range, so that float32 rounding
// does not decide about hits at exactly the maximum.
double farthest(const BeamTable& beams);

// Fills kPacket particles for each tile, from index `first` on. In a tile with fewer beams, the surplus particles are
// misses.
void launch(const MarchJob& job, std::span<const Tile> tiles, Particles& particles, std::size_t first);

// Turns the particles of launch() into hits after they have marched: lets them continue through transparent triangles
// (in fields with lists), fills the channels that `hits` has, and appends the beams that are neither hits nor misses to
// `unresolved`.
MarchCounts resolve(const MarchJob& job, const std::vector<CompactMaterial>& materials, std::span<const Tile> tiles,
                    HitRecords& records, std::size_t first, Hits& hits, std::vector<std::uint32_t>& unresolved);

}  // namespace scanmill
