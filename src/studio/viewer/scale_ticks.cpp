#include "viewer/scale_ticks.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace scanmill {

namespace {

constexpr std::size_t kMostTicks = 6;
// Least distance between ticks, as a fraction of the bar's length, so that labels do not overlap.
constexpr double kApart = 0.13;

// The step mantissa * 10^exponent.
struct Step {
  int mantissa = 1;
  int exponent = 0;

  double size() const { return times(1); }
  // Returns the length of n steps. Divides by a power of ten instead of multiplying by its inverse, which is not exact
  // in binary, so that results are printed as round numbers.
  double times(double n) const {
    const double whole = n * mantissa;
    return exponent < 0 ? whole / std::pow(10.0, -exponent) : whole * std::pow(10.0, exponent);
  }
  Step smaller() const {
    if (mantissa == 1) return {5, exponent - 1};
    return {mantissa == 5 ? 2 : 1, exponent};
  }
};

}  // namespace

std::vector<ScaleTick> scaleTicks(const Legend& legend) {
  const double low = legend.low;
  const double span = legend.high - low;
  if (!(span > 0) || !std::isfinite(span) || !(legend.power > 0)) return {{0.5, fmt::format("{:.4g}", low)}};
  std::vector<ScaleTick> ticks;
  Step step{1, static_cast<int>(std::ceil(std::log10(span)))};
  const auto multiples = [&] {
    constexpr double kSlack = 1e-9;  // tolerance as a fraction of the span, so that round values at the ends get a tick
    constexpr int kMostMultiples = 1000;
    constexpr double kLargest = 1e15;  // largest multiple; doubles above 9e15 do not represent all integers
    std::vector<ScaleTick> found;
    const double first = std::ceil((low - kSlack * span) / step.size());
    for (int k = 0; k < kMostMultiples && std::abs(first) < kLargest; ++k) {
      const double value = step.times(first + k);
      if (value > legend.high + kSlack * span) break;
      const double share = std::pow(std::clamp((value - low) / span, 0.0, 1.0), 1 / legend.power);
      found.push_back({share, fmt::format("{:.10g}", value == 0 ? 0.0 : value)});
    }
    return found;
  };
  constexpr int kMostSteps = 40;
  for (int tried = 0; tried < kMostSteps; ++tried, step = step.smaller()) {
    if (legend.integers && step.exponent < 0) break;
    std::vector<ScaleTick> found = multiples();
    if (legend.power == 1) {  // on a linear scale, all ticks have the same step
      if (found.size() > kMostTicks) break;
      if (found.size() > ticks.size()) ticks = std::move(found);
      continue;
    }
    // Add the multiples of this step that do not overlap ticks of larger steps.
    for (ScaleTick& tick : found) {
      const bool free = std::ranges::all_of(
          ticks, [&](const ScaleTick& other) { return std::abs(other.share - tick.share) >= kApart; });
      if (free && ticks.size() < kMostTicks) ticks.push_back(std::move(tick));
    }
    if (ticks.size() + 1 >= kMostTicks || step.size() < span / 100) break;
  }
  if (ticks.empty()) return {{0, fmt::format("{:.6g}", low)}, {1, fmt::format("{:.6g}", legend.high)}};
  std::ranges::sort(ticks, [](const ScaleTick& a, const ScaleTick& b) { return a.share < b.share; });
  return ticks;
}

std::string scaleTitle(const Legend& legend) {
  std::string title = legend.title;
  if (legend.power == 2) title += ", by its square root";
  if (legend.held) title += ", held";
  return title;
}

}  // namespace scanmill
