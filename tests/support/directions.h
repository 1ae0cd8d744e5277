#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "base/random.h"
#include "base/vec.h"

namespace scanmill {

// Unit vectors, uniform over the sphere; each stream gives others.
inline std::vector<Vec3d> randomDirections(std::size_t count, std::uint32_t stream = 0) {
  std::vector<Vec3d> directions;
  for (std::uint32_t i = 0; i < count; ++i) {
    const RandomBlock b = randomBlock({1, stream, 0, 0, i, 0, Purpose::Test});
    const double z = 2 * uniform(b[0]) - 1;
    const double azimuth = 2 * kPi * uniform(b[1]);
    const double s = std::sqrt(1 - z * z);
    directions.push_back({s * std::cos(azimuth), s * std::sin(azimuth), z});
  }
  return directions;
}

}  // namespace scanmill
