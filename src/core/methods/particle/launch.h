#pragma once

// Turns beams into particles: the first of the steps launch, march, resolve.

#include <span>

#include "methods/field/march_job.h"
#include "methods/particle/march.h"
#include "methods/world/resolve.h"

namespace scanmill {

// Sets `particles` to kPacket particles for each tile, in the order of the tiles. In a tile with fewer beams, the
// surplus particles are misses.
void launch(const MarchJob& job, std::span<const Tile> tiles, Particles& particles);

// The sections of beams that are inside of the job's box (m along the beams).
struct Sections {
  alignas(64) Lane begin, end;
};
Sections sectionsInsideBox(const MarchJob& job, const Rays& rays);

}  // namespace scanmill
