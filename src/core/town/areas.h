#pragma once

// Land of other kinds beside the roads, under polygons: woods, meadows, water, parking lots, squares. Town's frame, m.

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "town/map.h"

namespace scanmill::town {

class Areas {
 public:
  static constexpr double kReach = 8;  // m

  void add(MapArea area);
  const std::vector<MapArea>& all() const { return areas_; }

  // The kind of the smallest area there, and its index among all; none where no area is.
  std::optional<Land> at(const Point2& p) const;
  std::optional<std::uint32_t> indexAt(const Point2& p) const;
  // How far outside of the nearest area whose ground is no lawn (water, lots, squares), negative inside (m; more than
  // kReach counts as kReach).
  double outsideHard(const Point2& p) const;

 private:
  struct Extent {
    Point2 low, high;
    double size = 0;  // m^2
  };
  const std::vector<std::uint32_t>* near(const Point2& p) const;

  std::vector<MapArea> areas_;
  std::vector<Extent> extents_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;  // that each area's box and kReach reach into
};

}  // namespace scanmill::town
