#include <algorithm>

#include "town/layout.h"

namespace scanmill::town {
namespace {

std::vector<const Polygon*> ringsOf(const MapArea& area) {
  std::vector<const Polygon*> rings{&area.outline};
  for (const Polygon& hole : area.holes) rings.push_back(&hole);
  return rings;
}

}  // namespace

void Areas::add(MapArea area) {
  const auto [low, high] = extentOf(area.outline);
  // Coordinates are clamped to 2 km, which no town exceeds, to bound the number of cells.
  const auto limited = [](double v) { return std::clamp(v, -2000.0, 2000.0); };
  cells_.add({limited(low.x - kReach), limited(low.y - kReach)}, {limited(high.x + kReach), limited(high.y + kReach)},
             0, static_cast<std::uint32_t>(areas_.size()));
  sizes_.push_back(sizeOf(area.outline));
  areas_.push_back(std::move(area));
}

std::optional<Land> Areas::at(const Point2& p) const {
  const std::optional<std::uint32_t> index = indexAt(p);
  return index ? std::optional(areas_[*index].land) : std::nullopt;
}

std::optional<std::uint32_t> Areas::indexAt(const Point2& p) const {
  std::optional<std::uint32_t> index;
  double smallest = 1e18;
  for (const std::uint32_t i : cells_.at(p)) {
    if (sizes_[i] >= smallest || !isInside(ringsOf(areas_[i]), p)) continue;
    smallest = sizes_[i];
    index = i;
  }
  return index;
}

double Areas::outsideHard(const Point2& p) const {
  double least = kReach;
  for (const std::uint32_t i : cells_.at(p)) {
    const Land land = areas_[i].land;
    if (land != Land::Water && land != Land::Lot && land != Land::Paved) continue;
    const std::vector<const Polygon*> rings = ringsOf(areas_[i]);
    const double distance = distanceToRings(rings, p);
    least = std::min(least, isInside(rings, p) ? -distance : distance);
  }
  return least;
}

}  // namespace scanmill::town
