#pragma once

// Which rectangles of the ground are taken.

#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "models/models.h"

namespace scanmill::models {

// The rectangle on the ground that something stands on (m, rad).
struct Footprint {
  Point2 center;
  double halfX = 0, halfY = 0;
  double yaw = 0;

  // The place so many metres from its centre along its axes.
  Point2 at(double u, double v) const {
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    return {center.x + u * c - v * s, center.y + u * s + v * c};
  }
};

// The key of a cell of a grid over the ground, by its column and row.
constexpr std::uint64_t cellKey(std::int64_t column, std::int64_t row) {
  return static_cast<std::uint64_t>(column) << 32 ^ (static_cast<std::uint64_t>(row) & 0xFFFFFFFF);
}

class Occupancy {
 public:
  bool isFree(const Footprint& f) const;
  void add(const Footprint& f);

 private:
  std::vector<Footprint> taken_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;  // that each rectangle's circle reaches into
};

}  // namespace scanmill::models
