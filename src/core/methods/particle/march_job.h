#pragma once

// Turns beams into particles, and the particles' results into hits.

#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "methods/field/distance_field.h"
#include "methods/field/particle_launch.h"
#include "methods/particle/march.h"
#include "methods/particle/options.h"
#include "methods/world/resolve.h"
#include "methods/world/world.h"
#include "scan/hits.h"
#include "sensors/shot.h"

namespace scanmill {

// A shot, and the field through which its particles march.
struct MarchJob {
  const Shot& shot;
  const World& world;
  const DistanceField& field;
  const ShotFrame& frame;  // relative to the world's origin
  ParticleOptions::Refine refine;
  std::uint32_t steps;  // most steps of a particle
  Box box;              // m, relative to the world's origin: where particles may march
  bool whole;           // nothing of the scene lies outside of the box
};

// How many beams ended as neither hit nor miss, or as a hit that is not to be trusted.
struct MarchCounts {
  std::uint64_t exhausted = 0;  // used up their steps
  std::uint64_t left = 0;       // left the field, which does not hold all of the scene
  std::uint64_t touching = 0;   // started so near to a surface that they hit it at once
  MarchCounts& operator+=(const MarchCounts& o);
};

// Returns how far particles march (m): slightly beyond the sensor's maximum range, so that float32 rounding does not
// decide about hits at exactly the maximum.
double farthest(const BeamTable& beams);

// Fills kPacket particles for each tile, from index `first` on. If a tile has fewer beams, its remaining particles
// miss.
void launch(const MarchJob& job, std::span<const Tile> tiles, Particles& particles, std::size_t first);

// Turns the same particles into hits after they have marched: lets them continue through transparent triangles (in
// fields with lists), fills the channels that `hits` has, and adds the beams that are neither hits nor misses to
// `unresolved`.
MarchCounts resolve(const MarchJob& job, const std::vector<CompactMaterial>& materials, std::span<const Tile> tiles,
                    HitRecords& records, std::size_t first, Hits& hits, std::vector<std::uint32_t>& unresolved);

}  // namespace scanmill
