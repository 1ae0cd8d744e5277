#pragma once

// Turns beams into particles: the first of the steps launch, march, resolve.

#include <span>

#include "methods/field/march_job.h"
#include "methods/particle/march.h"
#include "methods/world/resolve.h"

namespace scanmill {

// Fills kPacket particles for each tile, from index `first` on. In a tile with fewer beams, the surplus particles are
// misses.
void launch(const MarchJob& job, std::span<const Tile> tiles, Particles& particles, std::size_t first);

// The sections of beams that are inside of the job's box (m along the beams).
struct Sections {
  alignas(64) Lane begin, end;
};
Sections sectionsInsideBox(const MarchJob& job, const Rays& rays);

}  // namespace scanmill
