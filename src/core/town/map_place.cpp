// Cuts out the square of a map from which a town is laid out: a part of one road and its surroundings.

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/vec.h"
#include "config/text.h"
#include "town/character.h"
#include "town/geometry.h"
#include "town/map.h"

namespace scanmill::town {
namespace {

using models::Kind;

constexpr double kLeastLength = 100;  // m, least length of a main road
constexpr double kAroundLand = 30;    // m by which areas of land may extend beyond the square

// Throws InputError: no road fits as main road. `longest`: length of the longest road with the wanted name (m).
[[noreturn]] void refuse(const Map& map, const Parameters& parameters, double longest, const Location& where) {
  std::vector<std::string> names;
  for (const MapRoad& road : map.roads) {
    if (!road.name.empty()) names.push_back(road.name);
  }
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  const std::string file = map.file.string();
  if (!parameters.road.empty() && !std::ranges::binary_search(names, parameters.road)) {
    throw InputError(where, "{} has no road with the name {}{}", file, quotedForMessage(parameters.road),
                     suggestion(parameters.road, names));
  }
  const std::string which = parameters.road.empty() ? "the longest road for cars" : quotedForMessage(parameters.road);
  throw InputError(where, "{} in {} is {:.0f} m long, but a main road needs {} m", which, file, longest, kLeastLength);
}

// Returns the index of a random main road: at least kLeastLength long, with the wanted name or, if no name is wanted,
// of residential class or above. The probability is proportional to the length. Throws InputError without such a road.
std::size_t drawMainRoad(const Map& map, const Parameters& parameters, Draw& draw, const Location& where) {
  std::vector<std::size_t> candidates;
  double totalLength = 0;
  double longest = 0;
  for (std::size_t i = 0; i < map.roads.size(); ++i) {
    const MapRoad& road = map.roads[i];
    const bool allowed = parameters.road.empty() ? road.kind <= RoadClass::Residential : road.name == parameters.road;
    if (!allowed || road.ring) continue;
    longest = std::max(longest, road.length());
    if (road.length() < kLeastLength) continue;
    candidates.push_back(i);
    totalLength += road.length();
  }
  if (candidates.empty()) refuse(map, parameters, longest, where);
  double remainingLength = draw.next() * totalLength;
  for (const std::size_t i : candidates) {
    remainingLength -= map.roads[i].length();
    if (remainingLength <= 0) return i;
  }
  return candidates.back();
}

// Returns the value of the key `district` that fits the density and the floors of the buildings at the main road.
std::string districtAbout(const MapPlace& place) {
  constexpr double kBeside = 40;  // m; buildings up to this distance from the main road are counted
  const std::vector<Point2>& main = place.roads.front().line;
  double groundArea = 0;  // m^2, ground area of the buildings
  double floorArea = 0;
  for (const MapBuilding& b : place.buildings) {
    const Nearest n = nearestOn(main, b.outline.front());
    if (n.distance > kBeside || n.along < place.mainFrom || n.along > place.mainTo) continue;
    const double area = areaOf(b.outline);
    groundArea += area;
    floorArea += area * b.usualFloors().value_or(2);
  }
  const double builtShare = groundArea / (2 * kBeside * (place.mainTo - place.mainFrom));
  if (builtShare < 0.03) return "rural";  // this and the next limits were chosen by eye
  const double meanFloors = floorArea / groundArea;
  return builtShare > 0.3 || (builtShare > 0.2 && meanFloors > 2.6) ? "dense" : "suburban";
}

// Cuts a town's square out of a map. Points of map_ are in the map's frame, points of place_ are relative to origin_.
class Cutter {
 public:
  Cutter(const Map& map, const Parameters& parameters, std::uint64_t seed, double reach, const Location& where)
      : map_(map), parameters_(parameters), reach_(reach), where_(where), draw_(seed, Kind::Map) {
    mainIndex_ = drawMainRoad(map, parameters, draw_, where);
  }

  // The origin, a random point of the main road, is set first, because all other steps use it.
  MapPlace cut() {
    const MapRoad& main = map_.roads[mainIndex_];
    warnOfInterruption(main);
    const double halfLength = std::min(parameters_.length, main.length()) / 2;
    const double middle = draw_.in(halfLength, std::max(halfLength, main.length() - halfLength));
    origin_ = pointAt(main.line, middle);
    place_.origin = degreesAt(map_, origin_);
    addMain(main);
    setBuiltUp(halfLength);
    for (std::size_t i = 0; i < map_.roads.size(); ++i) {
      if (i != mainIndex_) addOtherRoad(map_.roads[i]);
    }
    addJoints();
    addPathsAndBarriers();
    addBuildingsAndAreas();
    place_.district = districtAbout(place_);
    return std::move(place_);
  }

 private:
  // Return a point, a line or a building with coordinates relative to origin_.
  Point2 relative(const Point2& p) const { return {p.x - origin_.x, p.y - origin_.y}; }
  std::vector<Point2> relative(const std::vector<Point2>& line) const { return relativeTo(origin_, line); }
  MapBuilding relative(MapBuilding building) const {
    building.outline = relative(building.outline);
    for (Polygon& court : building.courts) court = relative(court);
    if (building.ridge) building.ridge = {relative(building.ridge->front()), relative(building.ridge->back())};
    for (MapBuilding& part : building.parts) part = relative(std::move(part));
    return building;
  }
  bool isWithin(const Point2& p, double half) const { return std::max(std::abs(p.x), std::abs(p.y)) < half; }

  // Warns if the main road is shorter than the parameter `length` and another long road has the same name.
  void warnOfInterruption(const MapRoad& main) const {
    if (main.name.empty() || main.length() >= parameters_.length) return;
    const bool continues = std::ranges::any_of(map_.roads, [&](const MapRoad& other) {
      return &other != &main && other.name == main.name && other.length() >= kLeastLength;
    });
    if (!continues) return;
    warn(
        "{}: {} is a main road of {:.0f} m, less than `length: {:.0f}`: the town has it only up to an "
        "interruption, such as a bridge or a tunnel, and other roads of this name are not joined to it",
        map_.file.string(), quotedForMessage(main.name), main.length(), parameters_.length);
  }

  // True if the bounding box of a line overlaps the square: a quick test, since most lines of a large map are outside.
  bool mayReach(const std::vector<Point2>& line) const {
    const auto [low, high] = extentOf(line);
    return low.x < reach_ && high.x > -reach_ && low.y < reach_ && high.y > -reach_;
  }

  // Adds the main road's parts in the square. The part through the origin comes first, as the town's main road; throws
  // InputError if this part is too short.
  void addMain(const MapRoad& main) {
    std::vector<std::vector<Point2>> runs = runsWithin(smoothLine(relative(main.line), kRoadStep), reach_);
    std::erase_if(runs, [](const std::vector<Point2>& run) { return run.size() < 3; });
    std::ranges::stable_sort(runs, {}, [](const auto& run) { return nearestOn(run, {0, 0}).distance; });
    const double length = runs.empty() ? 0 : lengthOf(runs.front());
    if (length < 0.8 * kLeastLength) {
      throw InputError(where_, "{} in {} is too winding for a main road: only {:.0f} m of it can be smoothed into one",
                       main.name.empty() ? "a road" : quotedForMessage(main.name), map_.file.string(), length);
    }
    for (std::vector<Point2>& run : runs) addRoad(main, std::move(run));
    mainNodes_.insert(main.nodes.begin(), main.nodes.end());
  }

  // Adds a road with the line `line` and the other properties of the map's road `like`.
  MapRoad& addRoad(const MapRoad& like, std::vector<Point2> line) {
    MapRoad& placed = place_.roads.emplace_back(like);
    placed.nodes.clear();
    placed.line = std::move(line);
    return placed;
  }

  // Sets the ends of the main road's built-up part, `halfLength` metres before and after the origin.
  void setBuiltUp(double halfLength) {
    constexpr double kEnd = 8;  // m, least distance between the built-up part and an end of the road
    const MapRoad& main = place_.roads.front();
    const double origin = nearestOn(main.line, {0, 0}).along;
    place_.mainFrom = std::max(kEnd, origin - halfLength);
    place_.mainTo = std::min(main.length() - kEnd, origin + halfLength);
  }

  // Cuts a road at its nodes on the main road and adds the pieces, reversed if only their end is on the main road.
  void addOtherRoad(const MapRoad& road) {
    const auto isOnMain = [&](std::ptrdiff_t i) {
      return mainNodes_.contains(road.nodes[static_cast<std::size_t>(i)]);
    };
    std::ptrdiff_t first = 0;  // indices of the first and the last point of a piece
    for (std::ptrdiff_t last = 1; last < std::ssize(road.line); ++last) {
      if (last + 1 < std::ssize(road.line) && !isOnMain(last)) continue;
      std::vector<Point2> line = relative({road.line.begin() + first, road.line.begin() + last + 1});
      const bool begins = isOnMain(first);
      const bool ends = !begins && isOnMain(last);
      first = last;
      if (!mayReach(line)) continue;
      MapRoad piece = road;
      if (ends) {
        std::ranges::reverse(line);
        piece.against = piece.oneWay;
      }
      addPiece(piece, line, begins || ends);
    }
  }

  // Adds the parts of `line` in the square, with the properties of `piece`. `joined`: `line` begins at the main road.
  void addPiece(const MapRoad& piece, const std::vector<Point2>& line, bool joined) {
    const std::vector<Point2> smooth = piece.ring ? evenLine(line, kRoadStep) : smoothLine(line, kRoadStep);
    bool first = true;
    for (std::vector<Point2>& run : runsWithin(smooth, reach_)) {
      const bool atMain = joined && first && distance(run.front(), smooth.front()) < 0.01;
      first = false;
      if (run.size() < 3) continue;
      MapRoad& placed = addRoad(piece, std::move(run));
      if (atMain) joinMain(placed);
    }
  }

  // Marks a road as a side road if it begins in the built-up part of the main road, at an angle large enough for turns.
  void joinMain(MapRoad& road) const {
    constexpr std::size_t kAhead = 6;   // points from the junction to where the angle is measured
    constexpr double kLeastSine = 0.5;  // least sine of the angle between the roads
    constexpr double kLargestGap = 3;   // m between the start of the road and the main road's line
    const Nearest n = nearestOn(place_.roads.front().line, road.line.front());
    const Point2 direction = directionOf(road.line.front(), road.line[std::min(road.line.size() - 1, kAhead)]);
    const double sine = n.heading.x * direction.y - n.heading.y * direction.x;  // positive: the road leads to the left
    if (n.distance >= kLargestGap || std::abs(sine) <= kLeastSine) return;
    if (n.along <= place_.mainFrom || n.along >= place_.mainTo) return;
    road.joins = n.along;
    road.joinsLeft = sine > 0;
  }

  // Adds a joint for each node that occurs more than once in the roads.
  void addJoints() {
    constexpr double kAround = 40;  // m; corners are rounded within this distance of a joint
    struct Node {
      Point2 position;
      int uses = 0;
    };
    std::map<std::int64_t, Node> nodes;  // by id
    for (const MapRoad& road : map_.roads) {
      for (std::size_t i = 0; i < road.nodes.size(); ++i) {
        Node& node = nodes[road.nodes[i]];
        node.position = relative(road.line[i]);
        ++node.uses;
      }
    }
    for (const auto& [id, node] : nodes) {
      if (node.uses > 1 && isWithin(node.position, reach_ + kAround)) place_.joints.push_back(node.position);
    }
  }

  // Adds the parts of paths and barriers in the square. The corners of paths are rounded.
  void addPathsAndBarriers() {
    const auto addRuns = [&](const auto& mapped, const auto& divided, auto& placed) {
      for (const auto& object : mapped) {
        const std::vector<Point2> line = relative(object.line);
        if (!mayReach(line)) continue;
        for (std::vector<Point2>& run : runsWithin(divided(line, kRoadStep), reach_)) {
          if (run.size() < 2) continue;
          placed.push_back(object);
          placed.back().line = std::move(run);
        }
      }
    };
    addRuns(map_.paths, smoothLine, place_.paths);
    addRuns(map_.barriers, denseLine, place_.barriers);
  }

  // Adds the buildings that are completely in the square, areas clipped to a larger square, and trees in the square.
  void addBuildingsAndAreas() {
    for (const MapBuilding& b : map_.buildings) {
      MapBuilding placed = relative(b);
      const auto within = [&](const Point2& p) { return isWithin(p, reach_); };
      if (std::ranges::all_of(placed.outline, within)) place_.buildings.push_back(std::move(placed));
    }
    for (const MapArea& a : map_.areas) {
      MapArea placed{a.land, relative(a.outline), {}, a.square};
      if (!mayReach(placed.outline)) continue;
      placed.outline = clipped(placed.outline, reach_ + kAroundLand);
      if (placed.outline.size() < 3) continue;
      for (const Polygon& hole : a.holes) {
        Polygon clippedHole = clipped(relative(hole), reach_ + kAroundLand);
        if (clippedHole.size() > 2) placed.holes.push_back(std::move(clippedHole));
      }
      place_.areas.push_back(std::move(placed));
    }
    for (MapTree tree : map_.trees) {
      tree.at = relative(tree.at);
      if (isWithin(tree.at, reach_)) place_.trees.push_back(tree);
    }
  }

  const Map& map_;
  const Parameters& parameters_;
  double reach_;  // m, half of the side of the square
  const Location& where_;
  Draw draw_;
  std::size_t mainIndex_ = 0;
  Point2 origin_;
  std::set<std::int64_t> mainNodes_;
  MapPlace place_;
};

}  // namespace

MapPlace cutOut(const Map& map, const Parameters& parameters, std::uint64_t seed, double reach, const Location& where) {
  return Cutter(map, parameters, seed, reach, where).cut();
}

}  // namespace scanmill::town
