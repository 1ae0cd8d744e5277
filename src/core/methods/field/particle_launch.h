#pragma once

#include <cstddef>
#include <cstdint>

#include "base/vec.h"
#include "methods/world/resolve.h"
#include "sensors/shot.h"

namespace scanmill {

// The particles of a shot. Their order: 16 columns of the first ring, the same 16 columns of each further ring, then
// the next 16 columns. The last group of 16 may exceed the columns; its surplus particles do not march.
struct ParticleLaunch {
  static constexpr std::uint32_t kTogether = 16;  // columns
  const Shot* shot;
  const ShotFrame* frame;  // relative to the world's origin
  Box box;                 // m, relative to the world's origin: where particles may march
  double farthest;         // m, how far particles go
  bool whole;              // nothing of the scene lies outside of the box
  bool corrected;          // without lists: hits are moved to the plane of the particle's triangle
  std::size_t size() const {
    return std::size_t{shot->beams->rings} * ((shot->beams->columns + kTogether - 1) / kTogether) * kTogether;
  }
};

}  // namespace scanmill
