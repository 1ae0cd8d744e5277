#pragma once

// The rectangles of the ground that objects occupy.

#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "models/models.h"

namespace scanmill::models {

// The rectangle on the ground that an object covers (m, rad).
struct Footprint {
  Point2 center;
  double halfX = 0, halfY = 0;
  double yaw = 0;

  // Returns the point at a distance of `u` and `v` metres from the centre along the rectangle's x and y axes.
  Point2 at(double u, double v) const {
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    return {center.x + u * c - v * s, center.y + u * s + v * c};
  }
};

// Returns the key of a cell of a grid over the ground, from its column and row.
constexpr std::uint64_t cellKey(std::int64_t column, std::int64_t row) {
  return static_cast<std::uint64_t>(column) << 32 ^ (static_cast<std::uint64_t>(row) & 0xFFFFFFFF);
}

class Occupancy {
 public:
  bool isFree(const Footprint& f) const;
  void add(const Footprint& f);

 private:
  std::vector<Footprint> taken_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;  // indices of rectangles near a cell
};

}  // namespace scanmill::models
