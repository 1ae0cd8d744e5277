#include "town/areas.h"

#include <algorithm>
#include <cmath>

namespace scanmill::town {
namespace {

constexpr double kCell = 32;  // m, side of a grid cell

bool isHard(Land land) {
  return land == Land::Water || land == Land::Lot || land == Land::Paved;
}

std::vector<const Polygon*> ringsOf(const MapArea& area) {
  std::vector<const Polygon*> rings{&area.outline};
  for (const Polygon& hole : area.holes) rings.push_back(&hole);
  return rings;
}

}  // namespace

void Areas::add(MapArea area) {
  Extent extent{{1e9, 1e9}, {-1e9, -1e9}, 0};
  for (const Point2& p : area.outline) {
    extent.low = {std::min(extent.low.x, p.x), std::min(extent.low.y, p.y)};
    extent.high = {std::max(extent.high.x, p.x), std::max(extent.high.y, p.y)};
  }
  extent.size = sizeOf(area.outline);
  const auto index = static_cast<std::uint32_t>(areas_.size());
  // Coordinates are clamped to 2 km, which no town exceeds, to bound the number of cells.
  const auto limited = [](double v) { return std::clamp(v, -2000.0, 2000.0); };
  models::forCells({limited(extent.low.x - kReach), limited(extent.low.y - kReach)},
                   {limited(extent.high.x + kReach), limited(extent.high.y + kReach)}, 0, kCell,
                   [&](std::uint64_t key) { cells_[key].push_back(index); });
  areas_.push_back(std::move(area));
  extents_.push_back(extent);
}

const std::vector<std::uint32_t>* Areas::near(const Point2& p) const {
  const auto cell = cells_.find(models::cellKeyAt(p, kCell));
  return cell == cells_.end() ? nullptr : &cell->second;
}

std::optional<Land> Areas::at(const Point2& p) const {
  const std::optional<std::uint32_t> index = indexAt(p);
  return index ? std::optional(areas_[*index].land) : std::nullopt;
}

std::optional<std::uint32_t> Areas::indexAt(const Point2& p) const {
  std::optional<std::uint32_t> index;
  double smallest = 1e18;
  if (const auto* found = near(p)) {
    for (const std::uint32_t i : *found) {
      if (extents_[i].size >= smallest || !isInside(ringsOf(areas_[i]), p)) continue;
      smallest = extents_[i].size;
      index = i;
    }
  }
  return index;
}

double Areas::outsideHard(const Point2& p) const {
  double least = kReach;
  if (const auto* found = near(p)) {
    for (const std::uint32_t i : *found) {
      if (!isHard(areas_[i].land)) continue;
      const std::vector<const Polygon*> rings = ringsOf(areas_[i]);
      const double distance = distanceToRings(rings, p);
      least = std::min(least, isInside(rings, p) ? -distance : distance);
    }
  }
  return least;
}

}  // namespace scanmill::town
