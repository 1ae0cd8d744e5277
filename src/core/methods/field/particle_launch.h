#pragma once

#include <cstddef>
#include <cstdint>

#include "base/vec.h"
#include "methods/world/resolve.h"
#include "sensors/shot.h"

namespace scanmill {

// The particles of a shot, in this order: 16 columns of the first ring, the same 16 columns of each further ring, then
// the next 16 columns. If the columns are not a multiple of 16, the surplus particles of the last group do not march.
struct ParticleLaunch {
  static constexpr std::uint32_t kTogether = 16;  // number of columns in a group
  const Shot* shot;
  const ShotFrame* frame;  // the shot's poses, relative to the world's origin
  Box box;                 // m, relative to the world's origin: particles march only inside of the box
  double farthest;         // m, length of the particles' paths
  bool whole;              // true if the box contains the complete scene
  std::size_t size() const {
    return std::size_t{shot->beams->rings} * ((shot->beams->columns + kTogether - 1) / kTogether) * kTogether;
  }
};

}  // namespace scanmill
