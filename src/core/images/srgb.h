#pragma once

// Converts between linear values and sRGB values (IEC 61966-2-1), both from 0 to 1.

#include <array>
#include <cmath>
#include <cstddef>

namespace scanmill {

inline double srgbOf(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

inline double linearOf(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

// Returns linearOf(i / 255) for each of the 256 values i of a byte.
inline const std::array<float, 256>& linearOfBytes() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = static_cast<float>(linearOf(static_cast<double>(i) / 255));
    return values;
  }();
  return table;
}

}  // namespace scanmill
