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

constexpr std::size_t kFanWidth = 40;

// Downward directions at these angles to the vertical (deg): kFanWidth directions all around for each angle.
inline std::vector<Vec3d> fan(const std::vector<double>& incidences) {
  std::vector<Vec3d> directions;
  for (const double incidence : incidences) {
    for (std::size_t k = 0; k < kFanWidth; ++k) {
      const double azimuth = 0.1 + 2 * kPi * static_cast<double>(k) / kFanWidth;
      const double i = radians(incidence);
      directions.push_back({std::sin(i) * std::cos(azimuth), std::sin(i) * std::sin(azimuth), -std::cos(i)});
    }
  }
  return directions;
}

}  // namespace scanmill
