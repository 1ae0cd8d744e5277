#pragma once

// Turns beams into particles, and the particles' results into hits.

#include <cstdint>
#include <span>
#include <vector>

#include "methods/field/march_job.h"
#include "methods/particle/march.h"
#include "methods/world/resolve.h"
#include "scan/hits.h"

namespace scanmill {

// Numbers of beams that are neither hit nor miss, or whose hit is unreliable.
struct MarchCounts {
  std::uint64_t exhausted = 0;  // beams whose particles used up all their steps
  std::uint64_t leftField = 0;  // beams whose particles left the field, which does not cover the complete scene
  std::uint64_t touching = 0;   // beams whose particles started so near to a surface that they hit it at once
  MarchCounts& operator+=(const MarchCounts& o);
};

// Fills kPacket particles for each tile, from index `first` on. In a tile with fewer beams, the surplus particles are
// misses.
void launch(const MarchJob& job, std::span<const Tile> tiles, Particles& particles, std::size_t first);

// Turns the particles of launch() into hits after they have marched: lets them continue through transparent triangles
// (in fields with lists), fills the channels that `hits` has, and appends the beams that are neither hits nor misses to
// `unresolved`.
MarchCounts resolve(const MarchJob& job, const std::vector<CompactMaterial>& materials, std::span<const Tile> tiles,
                    HitRecords& records, std::size_t first, Hits& hits, std::vector<std::uint32_t>& unresolved);

}  // namespace scanmill
