#include "town/roads.h"

#include <cmath>

#include "town/geometry.h"

namespace scanmill::town {
namespace {

constexpr double kCell = 8;       // m, side of a grid cell
constexpr std::size_t kRun = 4;   // number of successive segments that share a bounding box
constexpr double kRounding = 10;  // m, rounding of corners at joints: see at()
constexpr double kRingRounding = 4;
constexpr double kFull = 28;  // m from a joint; nearer corners are fully rounded
constexpr double kFade = 12;  // m beyond kFull, over which the rounding decreases to zero

CrossSection mixed(const CrossSection& a, const CrossSection& b, double part) {
  return {models::lerp(a.half, b.half, part),         models::lerp(a.parking, b.parking, part),
          models::lerp(a.curb, b.curb, part),         models::lerp(a.verge, b.verge, part),
          models::lerp(a.sidewalk, b.sidewalk, part), models::lerp(a.step, b.step, part),
          models::lerp(a.apron, b.apron, part),       models::lerp(a.shoulder, b.shoulder, part),
          models::lerp(a.median, b.median, part),     part < 0.5 ? a.lanes : b.lanes};
}

}  // namespace

Point2 Road::point(double distance) const {
  const double d = std::clamp(distance, 0.0, length());
  const auto next = static_cast<std::size_t>(std::upper_bound(at.begin() + 1, at.end() - 1, d) - at.begin());
  const double part = (d - at[next - 1]) / (at[next] - at[next - 1]);
  return models::lerp(line[next - 1], line[next], part);
}

Point2 Road::heading(double distance) const {
  const double d = std::clamp(distance, 0.0, length());
  const Point2 a = point(d - kRoadStep);
  const Point2 b = point(d + kRoadStep);
  const double size = std::hypot(b.x - a.x, b.y - a.y);
  return {(b.x - a.x) / size, (b.y - a.y) / size};
}

models::Spot besideRoad(const Road& road, double along, double lateral) {
  const Point2 p = road.point(along);
  const Point2 h = road.heading(along);
  return {{p.x - h.y * lateral, p.y + h.x * lateral}, std::atan2(h.y, h.x), 1, 0};
}

RoadNetwork::RoadNetwork() : jointCells_(kCell) {}

void RoadNetwork::add(Road road) {
  road.number = static_cast<std::uint32_t>(roads_.size());
  road.at.assign(1, 0.0);
  for (std::size_t i = 1; i < road.line.size(); ++i) {
    road.at.push_back(road.at.back() + distance(road.line[i - 1], road.line[i]));
  }
  for (std::size_t first = 0; first + 1 < road.line.size(); first += kRun) {
    const std::size_t last = std::min(first + kRun, road.line.size() - 1);
    Run run{road.number, static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last), road.line[first],
            road.line[first]};
    for (std::size_t i = first + 1; i <= last; ++i) {
      const Point2& p = road.line[i];
      run.low = {std::min(run.low.x, p.x), std::min(run.low.y, p.y)};
      run.high = {std::max(run.high.x, p.x), std::max(run.high.y, p.y)};
    }
    runs_.push_back(run);
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
      std::vector<RunOfCell>& cell = cells_[models::cellKey(column, row)];
      auto place = cell.end();
      while (place != cell.begin() && runs_[place[-1].run].road == run.road && place[-1].least > least) --place;
      cell.insert(place, {index, least});
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

void RoadNetwork::nearest(double x, double y, std::vector<Near>& found) const {
  found.clear();
  const auto cell = cells_.find(models::cellKeyAt({x, y}, kCell));
  if (cell == cells_.end()) return;
  constexpr double kRounded = 1e-6;  // m^2, bound on the rounding error of squared distances
  std::uint32_t nearestSegment = 0;  // of the last road in `found`
  for (const auto [index, nearness] : cell->second) {
    const Run& run = runs_[index];
    const bool known = !found.empty() && found.back().road == run.road;
    const double most = known ? found.back().distance : kReach * kReach;
    if (nearness > 0 && nearness * nearness - kRounded > most) continue;
    const Point2 out = run.outside(x, y);
    if (out.x * out.x + out.y * out.y - kRounded > most) continue;
    const Road& road = roads_[run.road];
    for (std::uint32_t i = run.first; i < run.last; ++i) {
      const Point2& a = road.line[i];
      const Point2& b = road.line[i + 1];
      const double dx = b.x - a.x;
      const double dy = b.y - a.y;
      const double size = road.at[i + 1] - road.at[i];
      const double projected = ((x - a.x) * dx + (y - a.y) * dy) / (size * size);
      const double part = std::clamp(projected, 0.0, 1.0);
      const double px = x - (a.x + dx * part);
      const double py = y - (a.y + dy * part);
      const double square = px * px + py * py;
      if (square > kReach * kReach) continue;
      if (found.empty() || found.back().road != run.road) found.push_back({1e9, run.road, 0, false, 0});
      // If segments are equally far, the first one in the line counts.
      if (square > found.back().distance || (square == found.back().distance && i > nearestSegment)) continue;
      nearestSegment = i;
      const bool isEnd = projected < 0 ? i == 0 : i + 2 == road.line.size();
      const double behind = isEnd ? std::abs(projected - part) * size : 0;
      found.back() = {square, run.road, road.at[i] + size * part, dx * py - dy * px >= 0, behind};
    }
  }
  for (Near& n : found) n.distance = std::sqrt(n.distance);
}

// `edge` is the distance to the nearest road's edge, as a polynomial smooth minimum over all roads, which rounds
// corners: if the distances to two edges differ by less than the rounding, the result is less than both distances, by
// at most a quarter of the rounding.
Beside RoadNetwork::at(const Point2& p) const {
  thread_local std::vector<Near> found;
  nearest(p.x, p.y, found);
  Beside beside;
  double least = 1e9;
  const double corner = found.size() > 1 ? std::max(roundingAt(p), 1e-3) : 1;
  const bool ring = std::any_of(found.begin(), found.end(), [&](const Near& n) { return roads_[n.road].ring; });
  const double rounding = ring ? std::min(corner, kRingRounding) : corner;
  for (const Near& n : found) {
    const CrossSection& own = roads_[n.road].section;
    // A road that ends at a joint must not widen the other roads on their far side. Therefore the distance to its edge
    // grows steeply beyond its end.
    constexpr double kSteep = 3;
    const double edge = n.distance - own.half + kSteep * n.behind * corner / kRounding * (found.size() > 1 ? 1 : 0);
    if (!beside.nearRoad) {
      beside = {true, edge, n.road, n.along, n.left ? n.distance : -n.distance, own};
      least = edge;
      continue;
    }
    const double part = std::clamp(0.5 + (beside.edge - edge) / (2 * rounding), 0.0, 1.0);
    beside.section = mixed(beside.section, own, part);
    beside.edge = models::lerp(beside.edge, edge, part) - rounding * part * (1 - part);
    if (edge < least) {
      least = edge;
      beside.road = n.road;
      beside.along = n.along;
      beside.lateral = n.left ? n.distance : -n.distance;
    }
  }
  // The island inside a roundabout, at the left of the ring's line, has no pavements, although the roads that join the
  // ring may have pavements.
  if (beside.nearRoad && roads_[beside.road].ring && beside.lateral > 0) beside.section = roads_[beside.road].section;
  return beside;
}

}  // namespace scanmill::town
