#pragma once

// Limits the number of points that are drawn while something moves.

#include <algorithm>
#include <cstdint>

namespace scanmill {

// Estimates the drawing speed from the time that previous pictures took.
class DrawPace {
 public:
  // Returns how many points of each item to draw at most (0: all), for `items` items with `total` points together.
  std::uint64_t mostOfEach(std::uint64_t total, std::size_t items) const {
    const auto all = std::max(static_cast<std::uint64_t>(pointsPerMs_ * kWantedMs), kLeast);
    return total <= all || items == 0 ? 0 : all / items;
  }

  void measured(std::uint64_t points, double ms) {
    if (points < kLeast / 2 || !(ms > 0)) return;
    const double seen = static_cast<double>(points) / ms;
    pointsPerMs_ += 0.5 * (std::clamp(seen, kSlowest, kFastest) - pointsPerMs_);
  }

 private:
  static constexpr double kWantedMs = 30;
  static constexpr std::uint64_t kLeast = 150'000;  // least limit for the points of all items together; about one scan
  static constexpr double kSlowest = 500;
  static constexpr double kFastest = 1e6;
  double pointsPerMs_ = 20'000;
};

}  // namespace scanmill
