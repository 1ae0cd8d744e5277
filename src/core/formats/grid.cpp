#include "formats/grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace scanmill {

namespace {

constexpr double kMaxIndex = (1 << 30) - 2;
constexpr double kHalfUlp = 0x1p-24;    // largest relative rounding error of a float32
constexpr double kFloatWhole = 0x1p24;  // integers up to here are exact in float32

}  // namespace

Grid chooseGrid(std::span<const float> low, std::span<const float> high, double bound, const std::string& what) {
  double extent = 0;
  double magnitude = 0;
  for (std::size_t c = 0; c < low.size(); ++c) {
    extent = std::max(extent, double{high[c]} - double{low[c]});
    magnitude = std::max({magnitude, std::fabs(double{low[c]}), std::fabs(double{high[c]})});
  }
  Grid grid;
  const double diagonal = std::sqrt(static_cast<double>(low.size()));  // diagonal of a cube of side 1
  const double axisBound = bound / diagonal;
  const double widest = 2 * axisBound * (1 - 1e-9);  // largest step, minus a margin for rounding the index in double
  // The step and all coordinates of grid points are whole multiples of `unit`, at most 2^24 times `unit`, and therefore
  // exact in float32.
  const double reach = std::max(extent, magnitude) + 2 * widest;
  const double unit =
      std::exp2(std::max(std::ceil(std::log2(reach / kFloatWhole)), std::floor(std::log2(widest)) - 20));
  const double step = std::floor(widest / unit) * unit;
  if (step > 0) {
    grid.step = static_cast<float>(step);
    for (const float l : low) grid.low.push_back(static_cast<float>(std::floor(l / unit) * unit));
    return grid;
  }
  // The bound must include three roundings by the reader: of the index, of the product and of the sum.
  const double rounding = kHalfUlp * (2 * extent + magnitude + 4 * axisBound);
  const double possible = rounding + extent / kMaxIndex;
  if (!(axisBound >= possible)) {
    throw InputError(
        fmt::format("{} over {:.6g} m, up to {:.6g} m from the origin, cannot be kept within {:.6g} mm "
                    "in 32-bit floats: {:.6g} mm are possible",
                    what, extent, magnitude, bound * 1e3, possible * diagonal * 1e3));
  }
  grid.step = std::nextafter(static_cast<float>(2 * (axisBound - rounding)), 0.0f);
  grid.low.assign(low.begin(), low.end());
  return grid;
}

int mostIndexBits(double reach, std::size_t components, double bound) {
  constexpr int kMostBits = 30;
  const double widest = 2 * bound / std::sqrt(static_cast<double>(components)) * (1 - 1e-9);
  // chooseGrid() rounds the step down to a multiple of a power of two; `unit` is an upper bound of that power.
  const double unit = std::max(2 * (2 * reach + 2 * widest) / kFloatWhole, widest * 0x1p-20);
  if (unit > widest / 2) return kMostBits;
  const double largest = (2 * reach + unit) / (widest - unit) + 1;
  return std::clamp(static_cast<int>(std::ceil(std::log2(largest + 1))), 1, kMostBits);
}

void quantise(std::span<const float> values, const Grid& grid, std::int32_t* indices) {
  const double perStep = 1 / double{grid.step};
  const auto index = [&](float value, float low) {
    return static_cast<std::int32_t>((double{value} - double{low}) * perStep + 0.5);
  };
  if (grid.low.size() == 3) {
    const float x = grid.low[0];
    const float y = grid.low[1];
    const float z = grid.low[2];
    for (std::size_t i = 0; i + 2 < values.size(); i += 3) {
      indices[i] = index(values[i], x);
      indices[i + 1] = index(values[i + 1], y);
      indices[i + 2] = index(values[i + 2], z);
    }
  } else {
    const std::size_t components = grid.low.size();
    for (std::size_t i = 0; i < values.size(); ++i) indices[i] = index(values[i], grid.low[i % components]);
  }
}

}  // namespace scanmill
