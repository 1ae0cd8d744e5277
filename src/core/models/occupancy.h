#pragma once

// The rectangles of the ground that objects occupy.

#include <cmath>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "models/models.h"

namespace scanmill::models {

// The rectangle on the ground that an object covers (m, rad).
struct Footprint {
  Point2 center;
  double halfX = 0, halfY = 0;
  double yaw = 0;

  // Returns the square about a point with sides of 2 * `half` metres.
  static Footprint square(const Point2& center, double half, double yaw = 0) { return {center, half, half, yaw}; }
  // Returns the point at a distance of `u` and `v` metres from the centre along the rectangle's x and y axes.
  Point2 at(double u, double v) const {
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    return {center.x + u * c - v * s, center.y + u * s + v * c};
  }
};

// The pose and size of an object on the ground.
struct Spot {
  Point2 at;
  double yaw = 0, scale = 1;
  double lean = 0;  // rad, roll about x
};

// Returns the rectangle that a model covers at a spot, enlarged by `margin` (m) on all sides.
Footprint footprint(const Model& model, const Spot& spot, double margin);

// Returns the pose of a model at a spot, with its origin at the height `z` (m).
Affine poseOf(const Spot& spot, double z);

// Returns the column that contains an x coordinate, or the row that contains a y coordinate. `side`: cell size (m).
inline std::int64_t cellOf(double v, double side) {
  return static_cast<std::int64_t>(std::floor(v / side));
}

// Returns the key of a cell of a grid, from its column and row.
constexpr std::uint64_t cellKey(std::int64_t column, std::int64_t row) {
  return static_cast<std::uint64_t>(column) << 32 ^ (static_cast<std::uint64_t>(row) & 0xFFFFFFFF);
}

// Returns the key of the cell that contains a point.
inline std::uint64_t cellKeyAt(const Point2& p, double side) {
  return cellKey(cellOf(p.x, side), cellOf(p.y, side));
}

// Calls visit(key) for all cells of `side` m that the rectangle from `low` to `high`, enlarged by `reach` m, overlaps.
template <class Visit>
void forCells(const Point2& low, const Point2& high, double reach, double side, const Visit& visit) {
  for (std::int64_t row = cellOf(low.y - reach, side); row <= cellOf(high.y + reach, side); ++row) {
    for (std::int64_t column = cellOf(low.x - reach, side); column <= cellOf(high.x + reach, side); ++column) {
      visit(cellKey(column, row));
    }
  }
}

// A grid over the ground with a list of indices in each cell, to find the objects near a point.
class CellIndex {
 public:
  explicit CellIndex(double side) : side_(side) {}  // m, side of a cell

  // Adds an index to the cell of a point, or to all cells that a rectangle, enlarged by `reach` metres, overlaps.
  void add(const Point2& p, std::uint32_t index) { cells_[cellKeyAt(p, side_)].push_back(index); }
  void add(const Point2& low, const Point2& high, double reach, std::uint32_t index) {
    forCells(low, high, reach, side_, [&](std::uint64_t key) { cells_[key].push_back(index); });
  }
  // Return the indices of a cell, or of the cell that contains a point, in the order in which they were added.
  std::span<const std::uint32_t> inCell(std::uint64_t key) const {
    const auto cell = cells_.find(key);
    return cell == cells_.end() ? std::span<const std::uint32_t>() : cell->second;
  }
  std::span<const std::uint32_t> at(const Point2& p) const { return inCell(cellKeyAt(p, side_)); }

 private:
  double side_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

// A set of rectangles. isFree() returns true if a rectangle overlaps no rectangle of the set.
class Occupancy {
 public:
  bool isFree(const Footprint& rectangle) const;
  void add(const Footprint& rectangle);

 private:
  static constexpr double kCell = 8;  // m, side of a grid cell
  std::vector<Footprint> rectangles_;
  CellIndex cells_{kCell};  // indices in rectangles_, in all cells that a rectangle's circumcircle may overlap
};

}  // namespace scanmill::models
