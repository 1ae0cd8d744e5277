#include "scene/road_path.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <queue>

#include "config/fields.h"

namespace scanmill {

namespace {

constexpr double kCell = 1;         // m, size of the cells of the search
constexpr double kClear = 2.5;      // m, free height above the surface
constexpr double kSteepest = 0.75;  // largest slope of a road, as a difference in height per distance
constexpr double kHalfWidth = 1;    // m, half of a vehicle's width
constexpr double kFromEdge = 2;     // m, wanted distance of the vehicle's middle from the edge of the road
constexpr double kOpen = 12;        // m; where an edge is at least this far away, there is no road to keep to
constexpr double kEdgeStep = 0.25;  // m, accuracy of the distance to an edge
constexpr double kNearest = 20;     // m, largest distance from an end to the surface
constexpr double kUncrowded = 2.5;  // m; paths avoid edges that are nearer
constexpr std::size_t kMostSearched = 4'000'000;
constexpr int kSmoothings = 6;
constexpr double kApart = 2;  // m, distance between the points of the result

class Road {
 public:
  Road(const SurfaceHeights& heights, const Ontology& ontology, const RoadTrip& trip)
      : heights_(heights), classes_(classIds(ontology, trip.classes, trip.where)), where_(trip.where) {}

  // Returns the height of the road at a point (m), if it is free up to kClear and climbs or falls at most by kSteepest
  // from the height `z` at the distance `far` (m).
  std::optional<double> height(double x, double y, double z, double far = kHalfWidth) const {
    const std::optional<double> here = heightAt(x, y, z, far);
    return here ? here : heightAt(x + kBesideSeam, y + kBesideSeam, z, far);
  }

  // Returns the distance (m) to the edge of the road in a direction (unit vector), at most kOpen.
  double toEdge(const Vec3d& position, const Vec3d& direction) const {
    double far = 0;
    double z = position.z;
    while (far < kOpen) {
      const Vec3d next = position + direction * (far + kEdgeStep);
      const std::optional<double> height = this->height(next.x, next.y, z);
      if (!height) break;
      z = *height;
      far += kEdgeStep;
    }
    return far;
  }

  // Returns the road's point nearest to a point, by its height too if that is not 0.
  Vec3d nearest(const Vec3d& point, const char* which) const {
    std::optional<Vec3d> best;
    double least = kNearest;
    constexpr int kCells = static_cast<int>(kNearest / kCell);
    for (int i = -kCells; i <= kCells; ++i) {
      for (int j = -kCells; j <= kCells; ++j) {
        const double x = i * kCell;
        const double y = j * kCell;
        for (const SurfaceHeights::Surface& s : heights_.at(point.x + x, point.y + y)) {
          const Vec3d at{point.x + x, point.y + y, s.height};
          const double far = point.z == 0 ? std::hypot(x, y) : length(at - point);
          if (far < least && isRoad(s) && hasRoom(at)) {
            least = far;
            best = at;
          }
        }
      }
    }
    if (best) return *best;
    throw InputError(
        where_, fmt::format("`{}`: within {:g} m of [{:g}, {:g}] is no surface of `on` with room for a vehicle", which,
                            kNearest, point.x, point.y));
  }

  // True if a vehicle has room at a point, whatever its heading.
  bool hasRoom(const Vec3d& p) const {
    if (!height(p.x, p.y, p.z)) return false;
    for (int k = 0; k < 8; ++k) {
      const double turn = k * kPi / 4;
      if (!height(p.x + kHalfWidth * std::cos(turn), p.y + kHalfWidth * std::sin(turn), p.z)) return false;
    }
    return true;
  }

 private:
  static constexpr double kSame = 0.05;  // m; surfaces whose heights differ by less are the same surface

  std::optional<double> heightAt(double x, double y, double z, double far) const {
    const std::vector<SurfaceHeights::Surface> all = heights_.at(x, y);
    for (auto s = all.rbegin(); s != all.rend(); ++s) {
      if (std::fabs(s->height - z) > kSteepest * far || s->slope > kSteepestGround || !isRoad(*s)) continue;
      const bool covered = std::ranges::any_of(all, [&](const SurfaceHeights::Surface& other) {
        return other.height > s->height + kSame && other.height < s->height + kClear;
      });
      if (!covered) return s->height;
    }
    return std::nullopt;
  }

  bool isRoad(const SurfaceHeights::Surface& s) const {
    return std::ranges::find(classes_, s.semantic) != classes_.end();
  }

  const SurfaceHeights& heights_;
  std::vector<std::uint16_t> classes_;
  Location where_;
};

// Finds the cheapest sequence of cells. Cells lie on a grid about the start, so that the result does not depend on
// where the scene's origin is.
class CellSearch {
 public:
  CellSearch(const Road& road, const Vec3d& from, const Vec3d& to)
      : road_(road), from_(from), to_(to), nearest_(from) {}

  // Returns the place nearest to the goal that the search has reached.
  const Vec3d& nearest() const { return nearest_; }

  // Returns the points of the cells from the start to the goal; empty if the goal cannot be reached.
  std::vector<Vec3d> run() {
    const Cell start{0, 0, 0};
    nodes_[start] = {from_, 0, start, true};
    open_.emplace(remaining(from_), start);
    while (!open_.empty() && nodes_.size() < kMostSearched) {
      const Cell cell = open_.top().second;
      open_.pop();
      Node& node = nodes_.at(cell);
      if (node.closed) continue;
      node.closed = true;
      if (remaining(node.position) < remaining(nearest_)) nearest_ = node.position;
      if (remaining(node.position) < kCell && std::fabs(node.position.z - to_.z) < 2 * kSteepest) return pathTo(cell);
      const Node own = node;
      for (int dx = -1; dx <= 1; ++dx) {
        for (int dy = -1; dy <= 1; ++dy) {
          if (dx != 0 || dy != 0) visit(cell, own, dx, dy);
        }
      }
    }
    return {};
  }

 private:
  using Cell = std::array<std::int64_t, 3>;  // x, y and storey
  struct Node {
    Vec3d position;          // m, world frame
    double cost = INFINITY;  // of the cheapest path so far from the start
    Cell before{};           // the cell before this one on that path
    bool room = false;       // a vehicle has room here
    bool closed = false;     // the path is final
  };

  // Returns the horizontal distance to the goal (m), which no path can be shorter than.
  double remaining(const Vec3d& p) const { return std::hypot(p.x - to_.x, p.y - to_.y); }

  void visit(const Cell& cell, const Node& own, int dx, int dy) {
    const double x = from_.x + static_cast<double>(cell[0] + dx) * kCell;
    const double y = from_.y + static_cast<double>(cell[1] + dy) * kCell;
    const std::optional<double> z = road_.height(x, y, own.position.z, kCell * std::hypot(dx, dy));
    if (!z) return;
    const Cell next{cell[0] + dx, cell[1] + dy, std::llround(*z / kClear)};
    const auto [found, isNew] = nodes_.try_emplace(next);
    Node& node = found->second;
    if (isNew) {
      node.position = {x, y, *z};
      node.room = road_.hasRoom(node.position);
    }
    if (!node.room || node.closed) return;
    const double cost = own.cost + std::hypot(dx, dy) * kCell * (1 + crowded(node.position));
    if (cost >= node.cost) return;
    node.cost = cost;
    node.before = cell;
    open_.emplace(cost + remaining(node.position), next);
  }

  // Returns the fraction of eight directions in which an edge is less than kUncrowded away.
  double crowded(const Vec3d& p) const {
    int blocked = 0;
    for (int k = 0; k < 8; ++k) {
      const double turn = k * kPi / 4;
      const double x = p.x + kUncrowded * std::cos(turn);
      const double y = p.y + kUncrowded * std::sin(turn);
      blocked += road_.height(x, y, p.z, kUncrowded) ? 0 : 1;
    }
    return blocked / 8.0;
  }

  std::vector<Vec3d> pathTo(Cell cell) const {
    std::vector<Vec3d> path{nodes_.at(cell).position};
    while (cell != Cell{0, 0, 0}) {
      cell = nodes_.at(cell).before;
      path.push_back(nodes_.at(cell).position);
    }
    std::ranges::reverse(path);
    return path;
  }

  const Road& road_;
  Vec3d from_, to_, nearest_;
  std::map<Cell, Node> nodes_;
  using Entry = std::pair<double, Cell>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open_;
};

// Averages each point with its neighbours, except the two ends, where the vehicle still has room.
void smooth(const Road& road, std::vector<Vec3d>& path) {
  const std::vector<Vec3d> before = path;
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    Vec3d p = before[i - 1] * 0.25 + before[i] * 0.5 + before[i + 1] * 0.25;
    const std::optional<double> z = road.height(p.x, p.y, before[i].z);
    if (!z) continue;
    p.z = *z;
    if (road.hasRoom(p)) path[i] = p;
  }
}

// Moves points sideways to the wanted distance from the road's edge.
void keepToSide(const Road& road, RoadSide side, std::vector<Vec3d>& path) {
  const std::vector<Vec3d> before = path;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Vec3d ahead = before[std::min(i + 3, path.size() - 1)] - before[i < 3 ? 0 : i - 3];
    const double far = std::hypot(ahead.x, ahead.y);
    if (far <= 0) continue;
    const Vec3d toLeft{-ahead.y / far, ahead.x / far, 0};
    const double left = road.toEdge(before[i], toLeft);
    const double right = road.toEdge(before[i], toLeft * -1);
    const double middle = (left + right) / 2;
    if (left >= kOpen || right >= kOpen) continue;
    const double wanted = side == RoadSide::Middle ? middle : std::min(kFromEdge, middle);
    const double move = side == RoadSide::Left ? left - wanted : wanted - right;
    Vec3d p = before[i] + toLeft * move;
    const std::optional<double> z = road.height(p.x, p.y, before[i].z);
    if (!z) continue;
    p.z = *z;
    if (road.hasRoom(p)) path[i] = p;
  }
}

}  // namespace

RoadSide readRoadSide(Fields& fields) {
  constexpr std::pair<const char*, RoadSide> kSides[]{
      {"right", RoadSide::Right}, {"left", RoadSide::Left}, {"middle", RoadSide::Middle}};
  return namedChoice(fields, "keep", kSides, RoadSide::Right).second;
}

RoadTrip readRoadTrip(Fields& fields) {
  RoadTrip trip;
  trip.where = fields.require("to").where;
  const auto point = [&](const char* key) {
    const std::vector<double> p = fields.numbers(key, {-1e7, 1e7});
    if (p.size() == 2 || p.size() == 3) return Vec3d{p[0], p[1], p.size() == 3 ? p[2] : 0};
    throw InputError(fields.require(key).where, fmt::format("{} must be [x, y] or [x, y, z] in m", key));
  };
  fields.require("from");
  trip.from = point("from");
  trip.to = point("to");
  const Location on = fields.require("on").where;
  trip.classes = fields.texts("on");
  if (trip.classes.empty()) throw InputError(on, "on must name classes, such as [road]");
  trip.keep = readRoadSide(fields);
  return trip;
}

std::vector<Vec3d> findRoadPath(const SurfaceHeights& heights, const Ontology& ontology, const RoadTrip& trip) {
  const Road road(heights, ontology, trip);
  const Vec3d from = road.nearest(trip.from, "from");
  const Vec3d to = road.nearest(trip.to, "to");
  CellSearch search(road, from, to);
  std::vector<Vec3d> path = search.run();
  if (path.size() < 2) {
    const Vec3d& end = search.nearest();
    throw InputError(
        trip.where,
        fmt::format("there is no path on the surfaces of `on` from [{:.1f}, {:.1f}] to [{:.1f}, {:.1f}] with "
                    "room for a vehicle; the nearest place that can be reached is [{:.1f}, {:.1f}]: name more "
                    "classes, or other points",
                    from.x, from.y, to.x, to.y, end.x, end.y));
  }
  for (int k = 0; k < kSmoothings; ++k) smooth(road, path);
  keepToSide(road, trip.keep, path);
  for (int k = 0; k < 2 * kSmoothings; ++k) smooth(road, path);
  std::vector<Vec3d> apart{path.front()};
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    const bool far = length(path[i] - apart.back()) >= kApart && length(path[i] - path.back()) >= kApart / 2;
    if (far) apart.push_back(path[i]);
  }
  apart.push_back(path.back());
  return apart;
}

std::vector<Vec3d> droppedOnGround(const SurfaceHeights& heights, const std::vector<Vec3d>& points,
                                   const Location& where) {
  std::vector<Vec3d> dropped;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d& to = points[i];
    const Vec3d& from = points[i == 0 ? 0 : i - 1];
    const int parts = std::max(1, static_cast<int>(std::hypot(to.x - from.x, to.y - from.y) / kCell));
    for (int k = i == 0 ? parts : 1; k <= parts; ++k) {
      Vec3d p = from + (to - from) * (static_cast<double>(k) / parts);
      const auto ground = heights.under(p, [](const SurfaceHeights::Surface& s) { return !s.thing; });
      if (!ground) throw InputError(where, fmt::format("at [{:.1f}, {:.1f}] is no ground below", p.x, p.y));
      p.z = ground->height;
      dropped.push_back(p);
    }
  }
  return dropped;
}

}  // namespace scanmill
