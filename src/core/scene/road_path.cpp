#include "scene/road_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <queue>

#include "config/fields.h"

namespace scanmill {

namespace {

// These values were chosen by eye for cars in the program's scenes. The comment of findRoadPath() states most of them.
constexpr double kCell = 1;            // m, size of the cells of the search
constexpr double kClearance = 2.5;     // m, free height above the road; also the height of the cells of the search
constexpr double kSteepest = 0.75;     // largest slope of a road, as a difference in height per distance
constexpr double kHalfWidth = 1;       // m, half of a vehicle's width
constexpr double kEdgeDistance = 2;    // m, desired distance of the vehicle's middle from the edge of the road
constexpr double kOpenDistance = 12;   // m; the path is not moved sideways where an edge is at least this far away
constexpr double kEdgeStep = 0.25;     // m, accuracy of the distance to an edge
constexpr double kSearchRadius = 20;   // m, largest distance from the trip's start or goal to the road
constexpr double kEasyDistance = 2.5;  // m; paths avoid edges that are nearer
constexpr std::size_t kMostCells = 4'000'000;
constexpr int kSmoothings = 6;  // number of smoothings before the path is moved sideways; twice as many follow
constexpr std::size_t kHeadingCells =
    3;                                // number of cells before and after a point over which the direction is measured
constexpr double kPointDistance = 2;  // m, least distance between the points of the result
constexpr int kDirections = 8;        // equally spaced directions in which room and edges are tested

// Returns the point at a horizontal distance (m) from `center` in one of kDirections directions.
Vec3d pointAround(const Vec3d& center, double distance, int direction) {
  const double angle = direction * 2 * kPi / kDirections;
  return {center.x + distance * std::cos(angle), center.y + distance * std::sin(angle), center.z};
}

// The road of a trip: all surfaces of the trip's classes.
class Road {
 public:
  Road(const SurfaceHeights& heights, const Ontology& ontology, const RoadTrip& trip)
      : heights_(heights), classes_(classIds(ontology, trip.classes, trip.where)), where_(trip.where) {}

  // Returns the height (m) of the lowest road surface at (x, y) that is free up to kClearance above it and at most
  // kSteepest * `distance` above or below `z`; nothing if there is none. `distance`: horizontal distance (m) of (x, y)
  // from the point whose height is `z`.
  std::optional<double> height(double x, double y, double z, double distance = kHalfWidth) const {
    const std::optional<double> height = heightAt(x, y, z, distance);
    return height ? height : heightAt(x + kBesideSeam, y + kBesideSeam, z, distance);
  }

  // Returns the distance (m) to the edge of the road in a direction (unit vector), at most kOpenDistance.
  double edgeDistance(const Vec3d& position, const Vec3d& direction) const {
    double distance = 0;
    double z = position.z;
    while (distance < kOpenDistance) {
      const Vec3d next = position + direction * (distance + kEdgeStep);
      const std::optional<double> height = this->height(next.x, next.y, z);
      if (!height) break;
      z = *height;
      distance += kEdgeStep;
    }
    return distance;
  }

  // Returns the point of the road nearest to `point` at which a vehicle has room; if point.z is 0, the distance is
  // horizontal. Throws InputError if there is none within kSearchRadius. `key`: the point's YAML key, for the message.
  Vec3d nearestRoom(const Vec3d& point, const char* key) const {
    std::optional<Vec3d> nearest;
    double leastDistance = kSearchRadius;
    constexpr int kCells = static_cast<int>(kSearchRadius / kCell);
    for (int i = -kCells; i <= kCells; ++i) {
      for (int j = -kCells; j <= kCells; ++j) {
        const double x = i * kCell;
        const double y = j * kCell;
        for (const SurfaceHeights::Surface& s : heights_.at(point.x + x, point.y + y)) {
          const Vec3d candidate{point.x + x, point.y + y, s.height};
          const double distance = point.z == 0 ? std::hypot(x, y) : length(candidate - point);
          if (distance < leastDistance && isRoad(s) && hasRoom(candidate)) {
            leastDistance = distance;
            nearest = candidate;
          }
        }
      }
    }
    if (nearest) return *nearest;
    throw InputError(where_, "`{}`: within {:g} m of [{:g}, {:g}] is no surface of `on` with room for a vehicle", key,
                     kSearchRadius, point.x, point.y);
  }

  // True if a vehicle has room at a point, whatever its heading.
  bool hasRoom(const Vec3d& p) const {
    if (!height(p.x, p.y, p.z)) return false;
    for (int k = 0; k < kDirections; ++k) {
      const Vec3d side = pointAround(p, kHalfWidth, k);
      if (!height(side.x, side.y, side.z)) return false;
    }
    return true;
  }

 private:
  static constexpr double kSameHeight = 0.05;  // m; surfaces whose heights differ by less are the same surface

  // Like height(), but looks only at (x, y); height() also looks beside it, since a ray exactly on a seam may miss.
  std::optional<double> heightAt(double x, double y, double z, double distance) const {
    const std::vector<SurfaceHeights::Surface> surfaces = heights_.at(x, y);  // the highest first
    for (auto s = surfaces.rbegin(); s != surfaces.rend(); ++s) {
      if (std::fabs(s->height - z) > kSteepest * distance || s->slope > kSteepestGround || !isRoad(*s)) continue;
      const bool covered = std::ranges::any_of(surfaces, [&](const SurfaceHeights::Surface& above) {
        return above.height > s->height + kSameHeight && above.height < s->height + kClearance;
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

// Finds the cheapest sequence of cells from `from` to `to` (A*). The grid of cells is centred at `from`, so that the
// result does not depend on where the scene's origin is.
class CellSearch {
 public:
  CellSearch(const Road& road, const Vec3d& from, const Vec3d& to)
      : road_(road), start_(from), goal_(to), nearestToGoal_(from) {}

  // Returns the point nearest to the goal that run() has reached.
  const Vec3d& nearestToGoal() const { return nearestToGoal_; }

  // Returns the points of the cells from the start to the goal; empty if the goal cannot be reached.
  std::vector<Vec3d> run() {
    nodes_[kStart] = {.position = start_, .cost = 0, .hasRoom = true};
    open_.emplace(goalDistance(start_), kStart);
    while (!open_.empty() && nodes_.size() < kMostCells) {
      const Cell cell = open_.top().second;
      open_.pop();
      Node& node = nodes_.at(cell);
      if (node.closed) continue;
      node.closed = true;
      if (goalDistance(node.position) < goalDistance(nearestToGoal_)) nearestToGoal_ = node.position;
      if (goalDistance(node.position) < kCell && std::fabs(node.position.z - goal_.z) < 2 * kSteepest)
        return pathTo(cell);
      for (int dx = -1; dx <= 1; ++dx) {
        for (int dy = -1; dy <= 1; ++dy) {
          if (dx != 0 || dy != 0) visit(cell, node, dx, dy);
        }
      }
    }
    return {};
  }

 private:
  // Indices of a cell: along x and y from the start, and the height in units of kClearance, so that a bridge and the
  // road below it are in different cells.
  using Cell = std::array<std::int64_t, 3>;
  static constexpr Cell kStart{0, 0, 0};
  struct Node {
    Vec3d position;          // m, world frame
    double cost = INFINITY;  // m, of the cheapest known path from the start: length and surcharges near edges
    Cell previous{};         // the cell before this one on that path
    bool hasRoom = false;    // a vehicle has room here
    bool closed = false;     // true: the cheapest path to the node is final
  };

  // Returns the horizontal distance to the goal (m), a lower bound of the length of any path to the goal.
  double goalDistance(const Vec3d& p) const { return std::hypot(p.x - goal_.x, p.y - goal_.y); }

  // Looks for road at the neighbour of a node, dx and dy cells away, and opens the neighbour if the path through the
  // node is its cheapest so far.
  void visit(const Cell& cell, const Node& node, int dx, int dy) {
    const double x = start_.x + static_cast<double>(cell[0] + dx) * kCell;
    const double y = start_.y + static_cast<double>(cell[1] + dy) * kCell;
    const double distance = kCell * std::hypot(dx, dy);
    const std::optional<double> z = road_.height(x, y, node.position.z, distance);
    if (!z) return;
    const Cell neighborCell{cell[0] + dx, cell[1] + dy, std::llround(*z / kClearance)};
    const auto [entry, isNew] = nodes_.try_emplace(neighborCell);
    Node& neighbor = entry->second;
    if (isNew) {
      neighbor.position = {x, y, *z};
      neighbor.hasRoom = road_.hasRoom(neighbor.position);
    }
    if (!neighbor.hasRoom || neighbor.closed) return;
    const double cost = node.cost + distance * (1 + blockedFraction(neighbor.position));
    if (cost >= neighbor.cost) return;
    neighbor.cost = cost;
    neighbor.previous = cell;
    open_.emplace(cost + goalDistance(neighbor.position), neighborCell);
  }

  // Returns the fraction of the directions in which an edge is less than kEasyDistance away.
  double blockedFraction(const Vec3d& p) const {
    int blocked = 0;
    for (int k = 0; k < kDirections; ++k) {
      const Vec3d side = pointAround(p, kEasyDistance, k);
      blocked += road_.height(side.x, side.y, side.z, kEasyDistance) ? 0 : 1;
    }
    return static_cast<double>(blocked) / kDirections;
  }

  // Returns the points from the start to a closed cell.
  std::vector<Vec3d> pathTo(Cell cell) const {
    std::vector<Vec3d> path{nodes_.at(cell).position};
    while (cell != kStart) {
      cell = nodes_.at(cell).previous;
      path.push_back(nodes_.at(cell).position);
    }
    std::ranges::reverse(path);
    return path;
  }

  const Road& road_;
  Vec3d start_, goal_, nearestToGoal_;
  std::map<Cell, Node> nodes_;
  // Open cells, ordered by cost plus distance to the goal, the least first. A cell may have several entries; run()
  // ignores all but the first that it takes out.
  using Entry = std::pair<double, Cell>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open_;
};

// Replaces a point of a path by `moved`, lifted or lowered to the road's surface, if a vehicle has room there.
void moveTo(const Road& road, Vec3d moved, Vec3d& point) {
  const std::optional<double> height = road.height(moved.x, moved.y, point.z);
  if (!height) return;
  moved.z = *height;
  if (road.hasRoom(moved)) point = moved;
}

// Replaces all points but the ends by a weighted mean with their neighbours, if a vehicle has room there.
void smooth(const Road& road, std::vector<Vec3d>& path) {
  const std::vector<Vec3d> old = path;
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    moveTo(road, old[i - 1] * 0.25 + old[i] * 0.5 + old[i + 1] * 0.25, path[i]);
  }
}

// Moves points to kEdgeDistance from the edge on `side`, or to the middle of narrow roads. Points in open places stay.
void keepToSide(const Road& road, RoadSide side, std::vector<Vec3d>& path) {
  const std::vector<Vec3d> old = path;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Vec3d& before = old[i - std::min(i, kHeadingCells)];
    const Vec3d along = old[std::min(i + kHeadingCells, path.size() - 1)] - before;
    const double alongLength = std::hypot(along.x, along.y);
    if (alongLength <= 0) continue;
    const Vec3d leftward{-along.y / alongLength, along.x / alongLength, 0};
    const double leftDistance = road.edgeDistance(old[i], leftward);
    const double rightDistance = road.edgeDistance(old[i], leftward * -1);
    if (leftDistance >= kOpenDistance || rightDistance >= kOpenDistance) continue;
    const double halfWidth = (leftDistance + rightDistance) / 2;
    const double edgeDistance = side == RoadSide::Middle ? halfWidth : std::min(kEdgeDistance, halfWidth);
    const double shift = side == RoadSide::Left ? leftDistance - edgeDistance : edgeDistance - rightDistance;
    moveTo(road, old[i] + leftward * shift, path[i]);
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
    throw InputError(fields.require(key).where, "{} must be [x, y] or [x, y, z] in m", key);
  };
  fields.require("from");
  trip.from = point("from");
  trip.to = point("to");
  const Location classesWhere = fields.require("on").where;
  trip.classes = fields.texts("on");
  if (trip.classes.empty()) throw InputError(classesWhere, "on must name classes, such as [road]");
  trip.keep = readRoadSide(fields);
  return trip;
}

std::vector<Vec3d> findRoadPath(const SurfaceHeights& heights, const Ontology& ontology, const RoadTrip& trip) {
  const Road road(heights, ontology, trip);
  const Vec3d from = road.nearestRoom(trip.from, "from");
  const Vec3d to = road.nearestRoom(trip.to, "to");
  CellSearch search(road, from, to);
  std::vector<Vec3d> path = search.run();
  if (path.size() < 2) {
    const Vec3d& reached = search.nearestToGoal();
    throw InputError(trip.where,
                     "there is no path on the surfaces of `on` from [{:.1f}, {:.1f}] to "
                     "[{:.1f}, {:.1f}] with room for a vehicle; the nearest place that can be "
                     "reached is [{:.1f}, {:.1f}]: name more classes, or other points",
                     from.x, from.y, to.x, to.y, reached.x, reached.y);
  }
  for (int k = 0; k < kSmoothings; ++k) smooth(road, path);
  keepToSide(road, trip.keep, path);
  for (int k = 0; k < 2 * kSmoothings; ++k) smooth(road, path);
  std::vector<Vec3d> points{path.front()};
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    const bool isApart =
        length(path[i] - points.back()) >= kPointDistance && length(path[i] - path.back()) >= kPointDistance / 2;
    if (isApart) points.push_back(path[i]);
  }
  points.push_back(path.back());
  return points;
}

std::vector<Vec3d> droppedOnGround(const SurfaceHeights& heights, const std::vector<Vec3d>& points,
                                   const Location& where) {
  std::vector<Vec3d> dropped;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d& end = points[i];
    const Vec3d& start = points[i == 0 ? 0 : i - 1];
    const int steps = std::max(1, static_cast<int>(std::hypot(end.x - start.x, end.y - start.y) / kCell));
    for (int step = i == 0 ? steps : 1; step <= steps; ++step) {
      Vec3d p = start + (end - start) * (static_cast<double>(step) / steps);
      const auto ground = heights.under(p, [](const SurfaceHeights::Surface& s) { return !s.thing; });
      if (!ground) throw InputError(where, "at [{:.1f}, {:.1f}] is no ground below", p.x, p.y);
      p.z = ground->height;
      dropped.push_back(p);
    }
  }
  return dropped;
}

}  // namespace scanmill
