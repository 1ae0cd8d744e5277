#pragma once

// Images in memory, and as PNG files.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "images/images.h"

namespace scanmill {

using Rgb = std::array<std::uint8_t, 3>;  // sRGB

// An RGB image, stored row by row from top to bottom.
struct Image {
  int width = 0, height = 0;
  std::vector<Rgb> pixels;

  Image() = default;
  Image(int imageWidth, int imageHeight, const Rgb& fill)
      : width(imageWidth), height(imageHeight), pixels(std::size_t(imageWidth) * std::size_t(imageHeight), fill) {}

  Rgb& at(int x, int y) { return pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)]; }
  const Rgb& at(int x, int y) const { return pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)]; }
};

// Returns the linear mixture of a (at t = 0) and b (at t = 1).
inline Rgb mix(const Rgb& a, const Rgb& b, double t) {
  Rgb mixed{};
  for (std::size_t c = 0; c < 3; ++c) mixed[c] = static_cast<std::uint8_t>(std::lround(a[c] + (b[c] - a[c]) * t));
  return mixed;
}

// Returns a PNG file of the image with 8-bit RGB. The same image always gives the same bytes, since no time is stored.
inline std::string encodePng(const Image& image) {
  static_assert(sizeof(Rgb) == 3);
  return encodePng(reinterpret_cast<const std::uint8_t*>(image.pixels.data()), image.width, image.height);
}

}  // namespace scanmill
