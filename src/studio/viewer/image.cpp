#include "viewer/image.h"

#include <cmath>

#include "images/images.h"

namespace scanmill {

Rgb mix(const Rgb& a, const Rgb& b, double t) {
  Rgb mixed{};
  for (std::size_t c = 0; c < 3; ++c) mixed[c] = static_cast<std::uint8_t>(std::lround(a[c] + (b[c] - a[c]) * t));
  return mixed;
}

std::string encodePng(const Image& image) {
  static_assert(sizeof(Rgb) == 3);
  return encodePng(reinterpret_cast<const std::uint8_t*>(image.pixels.data()), image.width, image.height);
}

}  // namespace scanmill
