#pragma once

// Polygons of land beside the roads: woods, meadows, water, parking lots, squares. Coordinates are in the town's frame
// (m).

#include <cstdint>
#include <optional>
#include <vector>

#include "town/map.h"

namespace scanmill::town {

class Areas {
 public:
  static constexpr double kReach = 8;  // m, largest distance that outsideHard() returns
  static constexpr double kCell = 32;  // m, side of a grid cell

  void add(MapArea area);
  const std::vector<MapArea>& all() const { return areas_; }

  // at() returns the kind of the smallest area at a point, indexAt() its index in all(); nullopt if no area
  // contains the point.
  std::optional<Land> at(const Point2& p) const;
  std::optional<std::uint32_t> indexAt(const Point2& p) const;
  // Returns the distance (m) to the nearest water, parking lot or square: negative inside of it, at most kReach.
  double outsideHard(const Point2& p) const;

 private:
  std::vector<MapArea> areas_;
  std::vector<double> sizes_;       // m^2, by area
  models::CellIndex cells_{kCell};  // of areas within kReach of a cell
};

}  // namespace scanmill::town
