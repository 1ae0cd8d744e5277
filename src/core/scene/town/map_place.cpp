#include "scene/town/map_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "scene/town/areas.h"

namespace scanmill::town {
namespace {

using parts::Kind;

constexpr double kLeast = 60;  // m, of a main road

double distance(const Point2& a, const Point2& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

std::size_t drawRoad(const Map& map, const Parameters& parameters, Draw& draw, const Location& where) {
  std::vector<std::size_t> fit;
  std::vector<std::string> names;
  double sum = 0;
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    const MapRoad& road = map.roads[i];
    if (!road.name.empty()) names.push_back(road.name);
    const bool wanted = parameters.road.empty() ? road.kind <= RoadClass::Residential : road.name == parameters.road;
    if (!wanted || road.ring || road.length() < kLeast) continue;
    fit.push_back(i);
    sum += road.length();
  }
  if (fit.empty()) {
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    const bool known = std::find(names.begin(), names.end(), parameters.road) != names.end();
    throw InputError(
        where,
        parameters.road.empty() || known
            ? fmt::format("{} has no {} of {} m or more", map.file.string(),
                          parameters.road.empty() ? "road for cars" : "stretch of '" + parameters.road + "'", kLeast)
            : fmt::format("{} has no road with the name '{}'{}", map.file.string(), parameters.road,
                          suggestion(parameters.road, names)));
  }
  // The longer the more likely.
  double pick = draw.next() * sum;
  for (const std::size_t i : fit) {
    pick -= map.roads[i].length();
    if (pick <= 0) return i;
  }
  return fit.back();
}

Point2 pointAt(const std::vector<Point2>& line, double along) {
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double size = distance(line[i - 1], line[i]);
    if (along <= size && size > 0) {
      return {parts::lerp(line[i - 1].x, line[i].x, along / size), parts::lerp(line[i - 1].y, line[i].y, along / size)};
    }
    along -= size;
  }
  return line.back();
}

// The runs of a line that lie in the square.
std::vector<std::vector<Point2>> runsWithin(const std::vector<Point2>& line, double reach) {
  std::vector<std::vector<Point2>> runs(1);
  for (const Point2& p : line) {
    if (std::max(std::abs(p.x), std::abs(p.y)) < reach) {
      runs.back().push_back(p);
    } else if (!runs.back().empty()) {
      runs.emplace_back();
    }
  }
  if (runs.back().empty()) runs.pop_back();
  return runs;
}

struct Nearest {
  double distance = 1e9;
  double along = 0;
  Point2 heading;
};

Nearest nearestOn(const std::vector<Point2>& line, const Point2& p) {
  Nearest nearest;
  double before = 0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double size = distance(line[i - 1], line[i]);
    const Point2 h{(line[i].x - line[i - 1].x) / size, (line[i].y - line[i - 1].y) / size};
    const double t = std::clamp((p.x - line[i - 1].x) * h.x + (p.y - line[i - 1].y) * h.y, 0.0, size);
    const double d = distance(p, {line[i - 1].x + h.x * t, line[i - 1].y + h.y * t});
    if (d < nearest.distance) nearest = {d, before + t, h};
    before += size;
  }
  return nearest;
}

// By how much of the land beside the main road is built on, and how high.
District districtAbout(const MapPlace& place) {
  constexpr double kBeside = 40;  // m
  const std::vector<Point2>& main = place.roads.front().road.line;
  double built = 0;
  double floors = 0;
  for (const MapBuilding& b : place.buildings) {
    const Nearest n = nearestOn(main, b.outline.front());
    if (n.distance > kBeside || n.along < place.mainFrom || n.along > place.mainTo) continue;
    const double size = sizeOf(b.outline);
    built += size;
    floors += size * b.floors.value_or(b.height ? static_cast<int>(*b.height / 2.9) : 2);
  }
  const double share = built / (2 * kBeside * (place.mainTo - place.mainFrom));
  if (share < 0.03) return District::Rural;
  return share > 0.3 || (share > 0.2 && floors > 2.6 * built) ? District::Dense : District::Suburban;
}

class Cutter {
 public:
  Cutter(const Map& map, const Parameters& parameters, std::uint64_t seed, double reach, const Location& where)
      : map_(map), parameters_(parameters), reach_(reach), draw_(seed, Kind::Map) {
    main_ = drawRoad(map, parameters, draw_, where);
  }

  MapPlace cut() {
    const MapRoad& main = map_.roads[main_];
    const double half = std::min(parameters_.length, main.length()) / 2;
    const double middle = draw_.in(half, std::max(half, main.length() - half));
    origin_ = pointAt(main.line, middle);
    place_.origin = degreesAt(map_, origin_);
    addMain(main, half);
    for (std::size_t i = 0; i < map_.roads.size(); ++i) {
      if (i != main_) addOther(map_.roads[i]);
    }
    addJoints();
    addRest();
    place_.district = districtAbout(place_);
    return std::move(place_);
  }

 private:
  Point2 moved(const Point2& p) const { return {p.x - origin_.x, p.y - origin_.y}; }
  std::vector<Point2> moved(const std::vector<Point2>& line) const {
    std::vector<Point2> made;
    made.reserve(line.size());
    for (const Point2& p : line) made.push_back(moved(p));
    return made;
  }
  bool within(const std::vector<Point2>& line) const {
    return std::any_of(line.begin(), line.end(),
                       [&](const Point2& p) { return std::max(std::abs(p.x), std::abs(p.y)) < reach_; });
  }

  void addMain(const MapRoad& main, double half) {
    // The run through the origin.
    MapPlace::PlacedRoad placed{main, {}, false};
    double best = 1e9;
    for (std::vector<Point2>& run : runsWithin(smoothLine(moved(main.line)), reach_)) {
      if (run.size() < 3) continue;
      const double d = nearestOn(run, {0, 0}).distance;
      if (d >= best) continue;
      best = d;
      placed.road.line = std::move(run);
    }
    for (const std::int64_t node : main.nodes) mainNodes_.insert(node);
    placed.road.nodes.clear();
    const double at = nearestOn(placed.road.line, {0, 0}).along;
    const double length = placed.road.length();
    place_.roads.push_back(std::move(placed));
    constexpr double kEnd = 8;  // m
    place_.mainFrom = std::max(kEnd, at - half);
    place_.mainTo = std::min(length - kEnd, at + half);
  }

  // Cut where it crosses the main road, and turned so that it begins there.
  void addOther(const MapRoad& road) {
    std::size_t from = 0;
    const auto meets = [&](std::size_t i) { return mainNodes_.contains(road.nodes[i]); };
    for (std::size_t i = 1; i < road.line.size(); ++i) {
      if (i + 1 < road.line.size() && !meets(i)) continue;
      std::vector<Point2> line(road.line.begin() + static_cast<std::ptrdiff_t>(from),
                               road.line.begin() + static_cast<std::ptrdiff_t>(i) + 1);
      line = moved(line);
      MapRoad piece = road;
      piece.nodes.clear();
      const bool begins = meets(from);
      const bool ends = !begins && meets(i);
      from = i;
      if (ends) {
        std::reverse(line.begin(), line.end());
        piece.against = piece.oneWay;
      }
      addPiece(piece, line, begins || ends);
    }
  }

  void addPiece(const MapRoad& piece, const std::vector<Point2>& line, bool joined) {
    const std::vector<Point2> smooth = smoothLine(line);
    bool first = true;
    for (std::vector<Point2>& run : runsWithin(smooth, reach_)) {
      const bool atMain = joined && first && distance(run.front(), smooth.front()) < 0.01;
      first = false;
      if (run.size() < 3) continue;
      MapPlace::PlacedRoad placed{piece, {}, false};
      if (atMain) {
        const std::vector<Point2>& main = place_.roads.front().road.line;
        const Nearest n = nearestOn(main, run.front());
        const Point2& on = run[std::min<std::size_t>(run.size() - 1, 6)];
        const double x = on.x - run.front().x;
        const double y = on.y - run.front().y;
        const double left = (n.heading.x * y - n.heading.y * x) / std::hypot(x, y);
        // Not where roads part at a flat angle: nobody turns there.
        if (n.distance < 3 && std::abs(left) > 0.5 && n.along > place_.mainFrom && n.along < place_.mainTo) {
          placed.joins = n.along;
          placed.joinsLeft = left > 0;
        }
      }
      placed.road.line = std::move(run);
      place_.roads.push_back(std::move(placed));
    }
  }

  void addJoints() {
    std::map<std::int64_t, std::pair<Point2, int>> uses;
    for (const MapRoad& road : map_.roads) {
      for (std::size_t i = 0; i < road.nodes.size(); ++i) {
        std::pair<Point2, int>& use = uses[road.nodes[i]];
        use.first = road.line[i];
        ++use.second;
      }
    }
    for (const auto& [node, use] : uses) {
      if (use.second > 1) place_.joints.push_back(moved(use.first));
    }
  }

  void addRest() {
    for (const std::vector<Point2>& path : map_.paths) {
      for (std::vector<Point2>& run : runsWithin(smoothLine(moved(path)), reach_)) {
        if (run.size() > 1) place_.paths.push_back(std::move(run));
      }
    }
    for (const MapBuilding& b : map_.buildings) {
      MapBuilding kept = b;
      kept.outline = moved(b.outline);
      if (!within(kept.outline)) continue;
      for (Polygon& court : kept.courts) court = moved(court);
      place_.buildings.push_back(std::move(kept));
    }
    for (const MapArea& a : map_.areas) {
      MapArea kept{a.land, moved(a.outline), {}};
      for (const Polygon& hole : a.holes) kept.holes.push_back(moved(hole));
      place_.areas.push_back(std::move(kept));
    }
    for (const MapBarrier& b : map_.barriers) {
      MapBarrier kept{b.kind, moved(b.line)};
      if (within(kept.line)) place_.barriers.push_back(std::move(kept));
    }
    for (const Point2& tree : map_.trees) {
      const Point2 at = moved(tree);
      if (within({at})) place_.trees.push_back(at);
    }
  }

  const Map& map_;
  const Parameters& parameters_;
  double reach_;
  Draw draw_;
  std::size_t main_ = 0;
  Point2 origin_;
  std::set<std::int64_t> mainNodes_;
  MapPlace place_;
};

}  // namespace

std::vector<Point2> smoothLine(const std::vector<Point2>& line) {
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += distance(line[i - 1], line[i]);
  const auto count = std::max(1, static_cast<int>(std::lround(length / kRoadStep)));
  std::vector<Point2> points;
  std::size_t segment = 1;
  double before = 0;
  for (int k = 0; k <= count; ++k) {
    const double at = length * k / count;
    while (segment + 1 < line.size() && before + distance(line[segment - 1], line[segment]) < at) {
      before += distance(line[segment - 1], line[segment]);
      ++segment;
    }
    const double size = distance(line[segment - 1], line[segment]);
    const double part = size > 0 ? std::clamp((at - before) / size, 0.0, 1.0) : 0;
    points.push_back({parts::lerp(line[segment - 1].x, line[segment].x, part),
                      parts::lerp(line[segment - 1].y, line[segment].y, part)});
  }
  constexpr int kPasses = 8;  // spread over about two points to both sides
  for (int pass = 0; pass < kPasses; ++pass) {
    std::vector<Point2> next = points;
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
      next[i] = {(points[i - 1].x + 2 * points[i].x + points[i + 1].x) / 4,
                 (points[i - 1].y + 2 * points[i].y + points[i + 1].y) / 4};
    }
    points = std::move(next);
  }
  return points;
}

MapPlace cutOut(const Map& map, const Parameters& parameters, std::uint64_t seed, double reach, const Location& where) {
  return Cutter(map, parameters, seed, reach, where).cut();
}

}  // namespace scanmill::town
