#include "images/reduction.h"

#include <algorithm>
#include <cstddef>
#include <iterator>

#include "images/srgb.h"

namespace scanmill {

namespace {

// Returns the sRGB byte whose linear value is nearest to `light` (linear, 0 to 1).
std::uint8_t encoded(float light) {
  const std::array<float, 256>& linear = linearOfBytes();
  const auto above = std::lower_bound(linear.begin(), linear.end(), light);
  if (above == linear.begin()) return 0;
  const auto below = std::prev(above);
  const auto nearest = above == linear.end() || light - *below < *above - light ? below : above;
  return static_cast<std::uint8_t>(nearest - linear.begin());
}

}  // namespace

Reduction::Reduction(int width, int factor)
    : width_(width), factor_(factor), sums_(static_cast<std::size_t>((width + factor - 1) / factor)) {}

void Reduction::add(const std::uint8_t* rgba) {
  const std::array<float, 256>& linear = linearOfBytes();
  for (int x = 0; x < width_; ++x, rgba += 4) {
    Sum& sum = sums_[static_cast<std::size_t>(x / factor_)];
    // The weight is above 0 even for alpha 0, so that a square of fully transparent pixels keeps its colour.
    const float weight = static_cast<float>(rgba[3]) + 1e-3f;
    for (std::size_t c = 0; c < 3; ++c) sum.light[c] += weight * linear[rgba[c]];
    sum.weight += weight;
    sum.alpha += rgba[3];
    ++sum.count;
  }
}

void Reduction::take(std::uint8_t* rgba) {
  for (Sum& sum : sums_) {
    for (std::size_t c = 0; c < 3; ++c) *rgba++ = encoded(sum.light[c] / sum.weight);
    *rgba++ = static_cast<std::uint8_t>((sum.alpha + sum.count / 2) / sum.count);
    sum = {};
  }
}

}  // namespace scanmill
