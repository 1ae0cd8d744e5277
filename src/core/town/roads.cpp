#include "town/roads.h"

#include <cmath>

#include "town/geometry.h"

namespace scanmill::town {
namespace {

constexpr std::size_t kRun = 4;      // number of successive segments that share a bounding box
constexpr double kRounding = 10;     // m, rounding of corners at joints: see at()
constexpr double kRingRounding = 4;  // m, at roundabouts
constexpr double kFull = 28;         // m from a joint, within which corners are fully rounded
constexpr double kFade = 12;         // m beyond kFull, over which the rounding decreases to zero

// Returns the linear mixture of two cross sections: `a` if t is 0, `b` if t is 1.
CrossSection mixed(const CrossSection& a, const CrossSection& b, double t) {
  return {models::lerp(a.half, b.half, t),         models::lerp(a.parking, b.parking, t),
          models::lerp(a.curb, b.curb, t),         models::lerp(a.verge, b.verge, t),
          models::lerp(a.sidewalk, b.sidewalk, t), models::lerp(a.step, b.step, t),
          models::lerp(a.apron, b.apron, t),       models::lerp(a.shoulder, b.shoulder, t),
          models::lerp(a.median, b.median, t),     t < 0.5 ? a.lanes : b.lanes};
}

}  // namespace

Point2 Road::point(double distance) const {
  const double d = std::clamp(distance, 0.0, length());
  const auto next = static_cast<std::size_t>(std::upper_bound(at.begin() + 1, at.end() - 1, d) - at.begin());
  return models::lerp(line[next - 1], line[next], (d - at[next - 1]) / (at[next] - at[next - 1]));
}

Point2 Road::heading(double distance) const {
  const double d = std::clamp(distance, 0.0, length());
  return directionOf(point(d - kRoadStep), point(d + kRoadStep));
}

models::Spot besideRoad(const Road& road, double along, double lateral) {
  const Point2 p = road.point(along);
  const Point2 h = road.heading(along);
  return {.at = {p.x - h.y * lateral, p.y + h.x * lateral}, .yaw = std::atan2(h.y, h.x)};
}

void RoadNetwork::add(Road road) {
  road.number = static_cast<std::uint32_t>(roads_.size());
  road.at.assign(1, 0.0);
  for (std::size_t i = 1; i < road.line.size(); ++i) {
    road.at.push_back(road.at.back() + distance(road.line[i - 1], road.line[i]));
  }
  for (std::size_t first = 0; first + 1 < road.line.size(); first += kRun) {
    const std::size_t last = std::min(first + kRun, road.line.size() - 1);
    const auto begin = road.line.begin() + static_cast<std::ptrdiff_t>(first);
    const auto [low, high] = extentOf({begin, begin + static_cast<std::ptrdiff_t>(last - first) + 1});
    runs_.push_back({road.number, static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last), low, high});
    enterLastRun();
  }
  roads_.push_back(std::move(road));
}

void RoadNetwork::enterLastRun() {
  constexpr double kHalfDiagonal = 0.7072 * kCell;
  const Run& run = runs_.back();
  const auto index = static_cast<std::uint32_t>(runs_.size() - 1);
  const auto middle = [](std::int64_t cell) { return (static_cast<double>(cell) + 0.5) * kCell; };
  const std::int64_t lastRow = models::cellOf(run.high.y + kReach, kCell);
  const std::int64_t lastColumn = models::cellOf(run.high.x + kReach, kCell);
  for (std::int64_t row = models::cellOf(run.low.y - kReach, kCell); row <= lastRow; ++row) {
    for (std::int64_t column = models::cellOf(run.low.x - kReach, kCell); column <= lastColumn; ++column) {
      const Point2 out = run.outside(middle(column), middle(row));
      const auto least = static_cast<float>(std::hypot(out.x, out.y) - kHalfDiagonal);
      if (least > kReach) continue;
      // Inserts the run so that the runs of this road, which are the last in the cell, stay sorted by `least`.
      std::vector<RunOfCell>& cell = cells_[models::cellKey(column, row)];
      auto position = cell.end();
      while (position != cell.begin() && runs_[position[-1].run].road == run.road && position[-1].least > least) {
        --position;
      }
      cell.insert(position, {index, least});
    }
  }
}

void RoadNetwork::addJoint(const Point2& joint) {
  constexpr double kAround = kFull + kFade;
  jointCells_.add(joint, joint, kAround, static_cast<std::uint32_t>(joints_.size()));
  joints_.push_back(joint);
}

double RoadNetwork::roundingAt(const Point2& p) const {
  double nearest = 1e9;
  for (const std::uint32_t i : jointCells_.at(p)) {
    nearest = std::min(nearest, std::hypot(p.x - joints_[i].x, p.y - joints_[i].y));
  }
  return kRounding * (1 - models::smooth((nearest - kFull) / kFade));
}

void RoadNetwork::findNearest(double x, double y, std::vector<NearestPoint>& nearest) const {
  nearest.clear();
  const auto cell = cells_.find(models::cellKeyAt({x, y}, kCell));
  if (cell == cells_.end()) return;
  constexpr double kRoundingError = 1e-6;  // m^2, bound on the error of squared distances
  for (const auto [index, least] : cell->second) {
    const Run& run = runs_[index];
    const bool sameRoad = !nearest.empty() && nearest.back().road == run.road;
    const double farthest = sameRoad ? nearest.back().squaredDistance : kReach * kReach;
    if (least > 0 && least * least - kRoundingError > farthest) continue;
    const Point2 outside = run.outside(x, y);
    if (outside.x * outside.x + outside.y * outside.y - kRoundingError > farthest) continue;
    findNearestOnRun(run, x, y, nearest);
  }
}

// Finds the run's nearest point within kReach. Appends this point to `nearest` or, if the last point in `nearest` is on
// the same road, keeps only the nearer of the two points. Of equally near points, the first along the road counts.
void RoadNetwork::findNearestOnRun(const Run& run, double x, double y, std::vector<NearestPoint>& nearest) const {
  const Road& road = roads_[run.road];
  for (std::uint32_t i = run.first; i < run.last; ++i) {
    const Point2& a = road.line[i];
    const Point2& b = road.line[i + 1];
    const double dx = b.x - a.x;
    const double dy = b.y - a.y;
    const double length = road.at[i + 1] - road.at[i];
    const double projected = ((x - a.x) * dx + (y - a.y) * dy) / (length * length);  // 0 at a, 1 at b
    const double t = std::clamp(projected, 0.0, 1.0);
    const double px = x - (a.x + dx * t);
    const double py = y - (a.y + dy * t);
    const double squaredDistance = px * px + py * py;
    if (squaredDistance > kReach * kReach) continue;
    if (nearest.empty() || nearest.back().road != run.road) nearest.push_back({1e9, run.road, 0, 0, false, 0});
    NearestPoint& best = nearest.back();
    if (squaredDistance > best.squaredDistance || (squaredDistance == best.squaredDistance && i > best.segment))
      continue;
    const bool isEnd = projected < 0 ? i == 0 : i + 2 == road.line.size();
    const double beyondEnd = isEnd ? std::abs(projected - t) * length : 0;
    best = {squaredDistance, run.road, i, road.at[i] + length * t, dx * py - dy * px >= 0, beyondEnd};
  }
}

// `edge` is a polynomial smooth minimum of the distances to the roads' edges, which rounds corners: if two distances
// differ by less than the rounding, the result is less than both distances, by at most a quarter of the rounding.
Beside RoadNetwork::at(const Point2& p) const {
  thread_local std::vector<NearestPoint> nearest;
  findNearest(p.x, p.y, nearest);
  const bool severalRoads = nearest.size() > 1;
  const double corner = severalRoads ? std::max(roundingAt(p), 1e-3) : 1;
  const bool ring = std::ranges::any_of(nearest, [&](const NearestPoint& n) { return roads_[n.road].ring; });
  const double rounding = ring ? std::min(corner, kRingRounding) : corner;
  Beside beside;
  double leastEdge = 1e9;
  for (const NearestPoint& n : nearest) {
    const CrossSection& section = roads_[n.road].section;
    const double distance = std::sqrt(n.squaredDistance);
    const double lateral = n.left ? distance : -distance;
    // Beyond a road's end the distance grows steeply, so that the road does not widen the other roads of the joint.
    constexpr double kSteepness = 3;
    const double edge = distance - section.half + (severalRoads ? kSteepness * n.beyondEnd * corner / kRounding : 0);
    if (!beside.nearRoad) {
      beside = {true, edge, n.road, n.along, lateral, section};
      leastEdge = edge;
      continue;
    }
    const double t = std::clamp(0.5 + (beside.edge - edge) / (2 * rounding), 0.0, 1.0);
    beside.section = mixed(beside.section, section, t);
    beside.edge = models::lerp(beside.edge, edge, t) - rounding * t * (1 - t);
    if (edge < leastEdge) {
      leastEdge = edge;
      beside.road = n.road;
      beside.along = n.along;
      beside.lateral = lateral;
    }
  }
  // A roundabout's island, at the left of the ring's line, has no pavements: it keeps the ring's cross section.
  if (beside.nearRoad && roads_[beside.road].ring && beside.lateral > 0) beside.section = roads_[beside.road].section;
  return beside;
}

}  // namespace scanmill::town
