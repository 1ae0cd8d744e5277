#include "viewer/image.h"

#include <algorithm>
#include <cmath>

#include "images/images.h"

namespace scanmill {

Rgb mix(const Rgb& a, const Rgb& b, double t) {
  Rgb out{};
  for (std::size_t c = 0; c < 3; ++c) out[c] = static_cast<std::uint8_t>(std::lround(a[c] + (b[c] - a[c]) * t));
  return out;
}

void fillRectangle(Image& image, int x, int y, int width, int height, const Rgb& color) {
  const int left = std::clamp(x, 0, image.width);
  const int right = std::clamp(x + width, left, image.width);
  for (int row = std::max(y, 0); row < std::min(y + height, image.height); ++row) {
    if (right > left) std::fill_n(&image.at(left, row), right - left, color);
  }
}

void paste(Image& image, const Image& source, int x, int y) {
  for (int row = 0; row < source.height; ++row) {
    for (int column = 0; column < source.width; ++column) {
      if (image.contains(x + column, y + row)) image.at(x + column, y + row) = source.at(column, row);
    }
  }
}

std::string encodePng(const Image& image) {
  static_assert(sizeof(Rgb) == 3);
  return encodePng(reinterpret_cast<const std::uint8_t*>(image.pixels.data()), image.width, image.height);
}

}  // namespace scanmill
