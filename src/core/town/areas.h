#pragma once

// Areas of other land beside the roads, given by polygons: woods, meadows, water, parking lots, squares. Town's frame,
// m.

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

  // Return the kind of the smallest area at a point, and the area's index in all(); none if no area is there.
  std::optional<Land> at(const Point2& p) const;
  std::optional<std::uint32_t> indexAt(const Point2& p) const;
  // Returns the distance to the nearest area that is not lawn (water, lots, squares), negative inside (m, at most
  // kReach).
  double outsideHard(const Point2& p) const;

 private:
  struct Extent {
    Point2 low, high;
    double size = 0;  // m^2
  };
  const std::vector<std::uint32_t>* near(const Point2& p) const;

  std::vector<MapArea> areas_;
  std::vector<Extent> extents_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;  // areas within kReach of each cell
};

}  // namespace scanmill::town
