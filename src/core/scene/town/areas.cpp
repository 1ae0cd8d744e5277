#include "scene/town/areas.h"

#include <algorithm>
#include <cmath>

namespace scanmill::town {
namespace {

constexpr double kCell = 32;  // m

std::int64_t cellOf(double v) {
  return static_cast<std::int64_t>(std::floor(v / kCell));
}
std::uint64_t cellKey(std::int64_t x, std::int64_t y) {
  return static_cast<std::uint64_t>(x) << 32 ^ (static_cast<std::uint64_t>(y) & 0xFFFFFFFF);
}

bool isHard(Land land) {
  return land == Land::Water || land == Land::Lot || land == Land::Paved;
}

std::vector<const Polygon*> ringsOf(const MapArea& area) {
  std::vector<const Polygon*> rings{&area.outline};
  for (const Polygon& hole : area.holes) rings.push_back(&hole);
  return rings;
}

}  // namespace

bool isInside(const std::vector<const Polygon*>& rings, const Point2& p) {
  bool inside = false;
  for (const Polygon* ring : rings) {
    for (std::size_t i = 0; i < ring->size(); ++i) {
      const Point2& a = (*ring)[i];
      const Point2& b = (*ring)[(i + 1) % ring->size()];
      if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) inside = !inside;
    }
  }
  return inside;
}

double distanceToRings(const std::vector<const Polygon*>& rings, const Point2& p) {
  double least = 1e9;
  for (const Polygon* ring : rings) {
    for (std::size_t i = 0; i < ring->size(); ++i) {
      const Point2& a = (*ring)[i];
      const Point2& b = (*ring)[(i + 1) % ring->size()];
      const double dx = b.x - a.x;
      const double dy = b.y - a.y;
      const double square = dx * dx + dy * dy;
      const double t = square > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / square, 0.0, 1.0) : 0;
      least = std::min(least, std::hypot(p.x - a.x - t * dx, p.y - a.y - t * dy));
    }
  }
  return least;
}

double sizeOf(const Polygon& ring) {
  double area = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point2& p = ring[i];
    const Point2& q = ring[(i + 1) % ring.size()];
    area += (p.x * q.y - q.x * p.y) / 2;
  }
  return area;
}

parts::Footprint rectangleAbout(const Polygon& ring) {
  parts::Footprint best;
  double smallest = 1e18;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point2& a = ring[i];
    const Point2& b = ring[(i + 1) % ring.size()];
    const double yaw = std::atan2(b.y - a.y, b.x - a.x);
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    double lowU = 1e18, highU = -1e18, lowV = 1e18, highV = -1e18;
    for (const Point2& p : ring) {
      const double u = p.x * c + p.y * s;
      const double v = p.y * c - p.x * s;
      lowU = std::min(lowU, u);
      highU = std::max(highU, u);
      lowV = std::min(lowV, v);
      highV = std::max(highV, v);
    }
    if ((highU - lowU) * (highV - lowV) >= smallest) continue;
    smallest = (highU - lowU) * (highV - lowV);
    const double u = (lowU + highU) / 2;
    const double v = (lowV + highV) / 2;
    best = {{u * c - v * s, u * s + v * c}, (highU - lowU) / 2, (highV - lowV) / 2, yaw};
  }
  return best;
}

void Areas::add(MapArea area) {
  Extent extent{{1e9, 1e9}, {-1e9, -1e9}, 0};
  for (const Point2& p : area.outline) {
    extent.low = {std::min(extent.low.x, p.x), std::min(extent.low.y, p.y)};
    extent.high = {std::max(extent.high.x, p.x), std::max(extent.high.y, p.y)};
  }
  extent.size = sizeOf(area.outline);
  const auto index = static_cast<std::uint32_t>(areas_.size());
  // No town is larger.
  const auto limited = [](double v) { return std::clamp(v, -2000.0, 2000.0); };
  for (std::int64_t y = cellOf(limited(extent.low.y - kReach)); y <= cellOf(limited(extent.high.y + kReach)); ++y) {
    for (std::int64_t x = cellOf(limited(extent.low.x - kReach)); x <= cellOf(limited(extent.high.x + kReach)); ++x) {
      cells_[cellKey(x, y)].push_back(index);
    }
  }
  areas_.push_back(std::move(area));
  extents_.push_back(extent);
}

const std::vector<std::uint32_t>* Areas::near(const Point2& p) const {
  const auto cell = cells_.find(cellKey(cellOf(p.x), cellOf(p.y)));
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
