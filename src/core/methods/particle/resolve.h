#pragma once

// Turns the records of particles that have marched into hits: the last of the steps launch, march, resolve.

#include <cstdint>
#include <span>
#include <vector>

#include "methods/field/march_job.h"
#include "methods/particle/march.h"
#include "methods/world/resolve.h"
#include "scan/hits.h"

namespace scanmill {

// Numbers of beams that are neither hit nor miss, or whose hit is unreliable.
struct UnreliableBeams {
  std::uint64_t exhausted = 0;  // beams whose particles used up all their steps
  std::uint64_t leftField = 0;  // beams whose particles left the field, which does not cover the complete scene
  std::uint64_t touching = 0;   // beams whose particles started so near to a surface that they hit it at once
  UnreliableBeams& operator+=(const UnreliableBeams& o);
};

// Turns the records of launched particles that have marched into hits: lets particles continue through transparent
// triangles (in fields with lists), fills the channels that `hits` has, and appends the beams that are neither hits nor
// misses to `unresolved`. `particles` and `records`: kPacket for each tile, in the order of the tiles.
UnreliableBeams resolve(const MarchJob& job, const std::vector<CompactMaterial>& materials, std::span<const Tile> tiles,
                        Particles& particles, HitRecords& records, Hits& hits, std::vector<std::uint32_t>& unresolved);

}  // namespace scanmill
