#pragma once

#include <cstddef>
#include <cstdint>

#include "base/vec.h"
#include "methods/world/resolve.h"
#include "sensors/shot.h"

namespace scanmill {

// The particles of a shot: 16 columns of a ring after the other, ring after ring, then the next 16 columns. Those that
// the last columns lack do not march.
struct ParticleLaunch {
  static constexpr std::uint32_t kTogether = 16;  // columns
  const Shot* shot;
  const ShotFrame* frame;  // of the world's origin
  Box box;                 // m, relative to the world's origin: where particles may march
  double farthest;         // m, how far they go
  bool whole;              // nothing of the scene lies outside of the box
  bool corrected;          // without lists: to the plane of the triangle at which a particle rests
  std::size_t size() const {
    return std::size_t{shot->beams->rings} * ((shot->beams->columns + kTogether - 1) / kTogether) * kTogether;
  }
};

}  // namespace scanmill
