#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "base/random.h"
#include "pipeline/scenes/scene_probe.h"
#include "scene/triangles.h"

namespace scanmill {
namespace {

// Parameters of the search, chosen by eye for cars. scene_probe.h documents the ones that affect the resulting path.
constexpr double kHeightCell = 0.25;  // m, size of the cells of the cached heights
constexpr double kAboveOrBelow = 1;   // m; a surface at most this far above or below a tested position is found
constexpr double kFreeHeight = 2.5;   // m, free height that a vehicle needs above the surface
constexpr double kRoomHalfWidth = 1;  // m, half of a vehicle's width
constexpr double kHalfLength = 2;     // m, half of a vehicle's length
constexpr int kArcLength = 4;         // m, length of an arc; a path consists of such arcs
constexpr double kLeastRadius = 6;    // m, of an arc
// Distance (m) from the vehicle's middle to the edge of the road, on the side where the vehicle drives.
constexpr double kSideDistance = 2;
constexpr double kOpenWidth = 12;     // m; a surface is an open place where its edge is at least this far away
constexpr double kWishLength = 24;    // m; in an open place, a vehicle chooses again whether to turn after this length
constexpr double kTurnShare = 0.4;    // probability that a vehicle in an open place chooses to turn
constexpr int kLookAhead = 12;        // m, distance that is tested beyond the end of an arc
constexpr int kMostStarts = 24;       // starting points that are tried
constexpr int kMostStepsBack = 2000;  // backtracking steps of a search

// Weights of the terms of an arc's cost, of which only the ratios matter. The bend of an arc is kLeastRadius times its
// curvature, from -1 to 1.
constexpr double kBendCost = 0.3;     // of the squared bend
constexpr double kChangeCost = 1.5;   // of the squared change of the bend
constexpr double kVisitCost = 3;      // of each earlier visit of the path to the spot ahead
constexpr double kWishCost = 8;       // of the difference from the wished bend; half if only the edge to keep to is far
constexpr double kWishedBend = 0.75;  // bend of a turn in an open place

// Position (m, world frame) and heading (rad) of a vehicle.
struct State {
  Vec3d position;
  double yaw = 0;

  // Returns the state after driving `metres` along an arc of this curvature (rad/m, positive to the left).
  State driven(double metres, double curvature) const {
    const double halfTurn = curvature * metres / 2;
    const double chordYaw = yaw + halfTurn;
    const double chord = std::fabs(halfTurn) < 1e-9 ? metres : metres * std::sin(halfTurn) / halfTurn;
    return {position + Vec3d{std::cos(chordYaw), std::sin(chordYaw), 0} * chord, yaw + curvature * metres};
  }
  // Returns the position at this distance (m) to the vehicle's left.
  Vec3d left(double metres) const { return position + Vec3d{-std::sin(yaw), std::cos(yaw), 0} * metres; }
};

// Finds where surfaces of given classes are free of obstacles. Caches results; only one thread may use it at a time.
class FreeSurface {
 public:
  FreeSurface(const SceneProbe& probe, std::vector<std::uint16_t> classes)
      : probe_(probe), classes_(std::move(classes)) {}

  // Returns the height of the surface at a position (m). Returns nothing if no surface of the given classes is within
  // about 1.5 m above or below the position, or if something is less than kFreeHeight above the surface.
  std::optional<double> height(const Vec3d& position) const {
    const auto cell = [](double coordinate) { return static_cast<std::int64_t>(std::floor(coordinate / kHeightCell)); };
    const auto layer = static_cast<std::int64_t>(std::floor(position.z));
    const std::tuple key{cell(position.x), cell(position.y), layer};
    if (const auto cached = heights_.find(key); cached != heights_.end()) return cached->second;
    const Vec3d middle{(static_cast<double>(std::get<0>(key)) + 0.5) * kHeightCell,
                       (static_cast<double>(std::get<1>(key)) + 0.5) * kHeightCell, static_cast<double>(layer) + 0.5};
    return heights_[key] = heightIn(middle);
  }

  // Returns the height of the surface under the vehicle's middle (m); nothing if a vehicle has no room in this state.
  std::optional<double> roomHeight(const State& s) const {
    const std::optional<double> middle = height(s.position);
    if (!middle || !height(s.left(kRoomHalfWidth)) || !height(s.left(-kRoomHalfWidth))) return std::nullopt;
    return middle;
  }

  // True if a vehicle can drive straight from one state to the other without touching an obstacle. Both states must
  // have room for a vehicle and be less than a few metres apart.
  bool isFreeBetween(const State& from, const State& to) const {
    std::vector<SceneProbe::Ray> rays;
    double reach = 0;  // m
    for (const double side : {-kRoomHalfWidth, 0.0, kRoomHalfWidth}) {
      for (const double rayHeight : {0.5, 1.5}) {  // m above the surface
        const Vec3d start = from.left(side) + Vec3d{0, 0, rayHeight};
        const Vec3d step = to.left(side) + Vec3d{0, 0, rayHeight} - start;
        const double distance = length(step);
        if (distance < kHeightCell) continue;
        rays.push_back({start, step * (1 / distance)});
        reach = std::max(reach, distance);
      }
    }
    return std::ranges::none_of(probe_.first(rays, reach), [](const auto& hit) { return hit.has_value(); });
  }

  // Returns the state one metre further along an arc; nothing if a vehicle has no room there, or if an obstacle is
  // between the two states.
  std::optional<State> oneMetreOn(const State& from, double curvature) const {
    State s = from.driven(1, curvature);
    const std::optional<double> height = roomHeight(s);
    if (!height) return std::nullopt;
    s.position.z = *height;
    return isFreeBetween(from, s) ? std::optional(s) : std::nullopt;
  }

  // Returns the distance from the vehicle's middle to the edge of the surface (m), at most kOpenWidth. `side`: 1 for
  // the left side, -1 for the right side.
  double edgeDistance(const State& s, double side) const {
    double distance = 0;
    while (distance < kOpenWidth && height(s.left(side * (distance + kHeightCell)))) distance += kHeightCell;
    return distance;
  }

 private:
  // Returns the result of height() for the cell with this middle.
  std::optional<double> heightIn(const Vec3d& middle) const {
    const double startHeight = 0.5 + kAboveOrBelow;  // m above the middle; half of a cell's height is 0.5 m
    const Vec3d start = middle + Vec3d{0, 0, startHeight};
    const auto below = probe_.first({start, {0, 0, -1}}, 2 * startHeight);
    if (!below || std::ranges::find(classes_, below->semantic) == classes_.end()) return std::nullopt;
    // The downward ray has already tested the space below its start; the upward ray tests the space above.
    const double untested = below->position.z + kFreeHeight - (middle.z + startHeight);
    if (untested > 0 && probe_.first({start, {0, 0, 1}}, untested)) return std::nullopt;
    return below->position.z;
  }

  const SceneProbe& probe_;
  std::vector<std::uint16_t> classes_;
  mutable std::map<std::tuple<std::int64_t, std::int64_t, std::int64_t>, std::optional<double>> heights_;
};

// A sequence of random numbers that depends on the seed and the drive's name.
class RandomNumbers {
 public:
  RandomNumbers(std::uint64_t seed, const std::string& name) {
    address_.seed = seed;
    address_.purpose = Purpose::RandomPath;
    // Computes the hash fnv1a() with the start value 0, which existing datasets depend on.
    for (const char c : name) address_.scene = (address_.scene ^ static_cast<unsigned char>(c)) * 16777619u;
  }
  // Returns the next random number, from 0 to 1.
  double next() {
    ++address_.frame;
    return uniform(randomBlock(address_)[0]);
  }
  // Returns a random number that depends only on `index`, the seed and the name, not on earlier calls.
  double at(std::uint32_t index) const {
    RandomAddress address = address_;
    address.frame = index;
    address.sensor = 1;
    return uniform(randomBlock(address)[0]);
  }

 private:
  RandomAddress address_;
};

// The triangles of given classes that are less than 60 degrees steep.
struct FlatTriangles {
  std::vector<std::array<Vec3d, 3>> triangles;  // corners (m, world frame)
  std::vector<double> sums;                     // m^2, seen from above: total area up to this triangle
};

FlatTriangles flatTriangles(const Scene& scene, const std::vector<std::uint16_t>& classes) {
  FlatTriangles flat;
  double sum = 0;
  forEachTriangleOf(scene, classes, scene.instances.size(),
                    [&](std::uint32_t, std::uint32_t, const std::array<Vec3d, 3>& corners) {
                      const Vec3d normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
                      if (!(std::fabs(normal.z) > length(normal) / 2)) return;  // the cosine of 60 degrees is 1/2
                      sum += std::fabs(normal.z) / 2;
                      flat.triangles.push_back(corners);
                      flat.sums.push_back(sum);
                    });
  return flat;
}

// Returns a random point on the triangles, uniformly by their area as seen from above.
Vec3d samplePoint(const FlatTriangles& flat, RandomNumbers& random) {
  const double area = random.next() * flat.sums.back();
  const auto sum = std::upper_bound(flat.sums.begin(), flat.sums.end() - 1, area);
  const double u = random.next();
  const double v = random.next();
  return pointInTriangle(flat.triangles[static_cast<std::size_t>(sum - flat.sums.begin())], u, v);
}

// A depth-first search over arcs, which tries the cheapest arc first.
class PathSearch {
 public:
  PathSearch(const FreeSurface& surface, const RandomPath& request, const RandomNumbers& random)
      : surface_(surface), request_(request), random_(random) {}

  // Returns the points of the longest path from `start` that the search finds. The search ends when a path has the
  // requested length, or after kMostStepsBack backtracking steps.
  std::vector<Vec3d> longestPath(const State& start) {
    std::vector<Node> nodes{openNode({start, 0}, 0)};
    std::vector<Vec3d> longest;
    int stepsBack = 0;
    while (!nodes.empty() && stepsBack < kMostStepsBack) {
      if (nodes.size() > longest.size()) {
        longest.clear();
        for (const Node& node : nodes) longest.push_back(node.end.state.position);
      }
      if (static_cast<double>(nodes.size() - 1) * kArcLength >= request_.length) break;
      Node& last = nodes.back();
      if (last.next == last.arcs.size()) {
        ++stepsBack;
        --visits_[coarseSpot(last.end.state)];
        deadEnds_.insert(fineSpot(last.end.state));
        nodes.pop_back();
        continue;
      }
      nodes.push_back(openNode(last.arcs[last.next++].end, static_cast<double>(nodes.size()) * kArcLength));
    }
    return longest;
  }

 private:
  struct End {
    State state;
    double curvature;  // rad/m, of the arc
  };
  struct Arc {
    End end;
    double cost;
  };
  struct Node {
    End end;
    std::vector<Arc> arcs;  // arcs that start at this node, the cheapest first
    std::size_t next = 0;   // index of the next arc to try
  };
  using Spot = std::tuple<std::int64_t, std::int64_t, std::int64_t, int>;

  // Returns a key that is equal for states of similar position and heading. `size`: size of a position cell (m).
  // `headings`: number of sectors into which headings are divided.
  static Spot spotOf(const State& s, double size, int headings) {
    const auto heading = static_cast<int>(std::lround(s.yaw / (2 * kPi) * headings));
    return {std::llround(s.position.x / size), std::llround(s.position.y / size),
            std::llround(s.position.z / kFreeHeight), ((heading % headings) + headings) % headings};
  }
  static Spot coarseSpot(const State& s) { return spotOf(s, kLookAhead, 8); }  // where the path has been
  static Spot fineSpot(const State& s) { return spotOf(s, 1, 24); }            // where the path cannot go on

  // Counts a visit of `end` and returns its node with all drivable arcs. `driven`: length of the path up to `end` (m).
  Node openNode(const End& end, double driven) {
    ++visits_[coarseSpot(end.state)];
    Node node{end, {}};
    const double choice = random_.at(static_cast<std::uint32_t>(driven / kWishLength));
    const double wishedCurvature = choice < kTurnShare / 2       ? kWishedBend / kLeastRadius
                                   : choice < 1 - kTurnShare / 2 ? 0
                                                                 : -kWishedBend / kLeastRadius;
    constexpr int kBends = 4;  // arcs to each side
    for (int k = -kBends; k <= kBends; ++k) {
      const double curvature = k / (kBends * kLeastRadius);
      if (const std::optional<Arc> arc = arcOf(end, curvature, wishedCurvature)) node.arcs.push_back(*arc);
    }
    std::ranges::stable_sort(node.arcs, {}, &Arc::cost);
    return node;
  }

  // Returns the arc of this curvature (rad/m) that starts at `end`, the end of another arc. Returns nothing if a
  // vehicle has no room on the arc, or if its end is known as a dead end. `wishedCurvature`: the curvature that the
  // vehicle prefers in open places (rad/m).
  std::optional<Arc> arcOf(const End& end, double curvature, double wishedCurvature) const {
    State s = end.state;
    for (int metre = 0; metre < kArcLength; ++metre) {
      const std::optional<State> next = surface_.oneMetreOn(s, curvature);
      if (!next) return std::nullopt;
      s = *next;
    }
    if (deadEnds_.contains(fineSpot(s))) return std::nullopt;
    const double bend = kLeastRadius * curvature;
    const double change = kLeastRadius * (curvature - end.curvature);
    double cost = kBendCost * bend * bend + kChangeCost * change * change;
    // Rate the end of the arc and two points straight ahead of it, since rating the end alone makes the path oscillate.
    for (const double ahead : {0.0, 4.0, 8.0}) cost += lateralCost(s.driven(ahead, 0), curvature, wishedCurvature);
    const auto [aheadLength, aheadState] = lookAhead(s);
    if (const auto visits = visits_.find(coarseSpot(aheadState)); visits != visits_.end())
      cost += kVisitCost * visits->second;
    cost += kLookAhead - aheadLength;
    return Arc{{s, curvature}, cost};
  }

  // Returns the cost of a state. On roads, the cost grows with the lateral distance from the preferred line. In open
  // places, it grows with the difference between `curvature` and `wishedCurvature` (rad/m). Off the surface, it is
  // constant.
  double lateralCost(State s, double curvature, double wishedCurvature) const {
    constexpr double kQuadratic = 2;  // m, lateral distance up to which the cost grows quadratically, then linearly
    const std::optional<double> height = surface_.height(s.position);
    if (!height) return 2 * kQuadratic * kQuadratic;
    s.position.z = *height;
    const double left = surface_.edgeDistance(s, 1);
    const double right = surface_.edgeDistance(s, -1);
    const double wishCost = kWishCost * kLeastRadius * std::fabs(curvature - wishedCurvature);
    if (left >= kOpenWidth && right >= kOpenWidth) return wishCost;
    const double edge = request_.keep == RoadSide::Left ? left : right;  // m, distance to the edge to keep to
    const double halfWidth = (left + right) / 2;
    const double preferred = request_.keep == RoadSide::Middle ? halfWidth : std::min(kSideDistance, halfWidth);
    const double offset = std::fabs(edge - preferred);
    return (offset < kQuadratic ? offset * offset : kQuadratic * (2 * offset - kQuadratic)) +
           (edge >= kOpenWidth ? wishCost / 2 : 0);
  }

  // Tests five arcs that start at `from`. Returns how far a vehicle can drive on the best of these arcs (m, at most
  // kLookAhead), and the state that it reaches.
  std::pair<double, State> lookAhead(const State& from) const {
    std::pair<double, State> farthest{0, from};
    for (const double bend : {0.0, 0.5, -0.5, 1.0, -1.0}) {
      State s = from;
      int metres = 0;  // driven so far
      for (; metres < kLookAhead; ++metres) {
        const std::optional<State> next = surface_.oneMetreOn(s, bend / kLeastRadius);
        if (!next) break;
        s = *next;
      }
      if (metres > farthest.first) farthest = {metres, s};
      if (metres == kLookAhead) break;
    }
    return farthest;
  }

  const FreeSurface& surface_;
  const RandomPath& request_;
  const RandomNumbers& random_;
  std::map<Spot, int> visits_;  // number of times that the current path has passed each spot
  std::set<Spot> deadEnds_;     // spots from which the search found no path of the required length
};

// Tests kHeadings evenly spaced headings at `position`, of which the first is random. Returns the state from which a
// vehicle can drive farthest straight ahead; nothing if it cannot drive farther than two arcs in any heading.
std::optional<State> startAt(const FreeSurface& surface, Vec3d position, RandomNumbers& random) {
  constexpr int kHeadings = 32;
  constexpr int kFarEnough = 40;  // m; longer distances are not measured
  std::optional<State> best;
  int farthest = 2 * kArcLength;
  const double firstYaw = random.next() * 2 * kPi;
  for (int i = 0; i < kHeadings; ++i) {
    const State start{position, firstYaw + i * 2 * kPi / kHeadings};
    if (!surface.roomHeight(start) || !surface.roomHeight(start.driven(-kHalfLength, 0))) continue;
    std::optional<State> state = start;
    int metres = 0;  // driven so far
    for (; state && metres < kFarEnough; ++metres) state = surface.oneMetreOn(*state, 0);
    if (metres <= farthest) continue;
    farthest = metres;
    best = start;
  }
  return best;
}

}  // namespace

std::vector<Vec3d> findRandomPath(const SceneProbe& probe, const RandomPath& request, std::uint64_t seed,
                                  const std::string& name) {
  const Scene& scene = probe.scene();
  const std::vector<std::uint16_t> classes = classIds(scene.ontology, request.classes, request.where);
  const std::string classNames = fmt::format("{}", fmt::join(request.classes, ", "));
  const FlatTriangles flat = flatTriangles(scene, classes);
  if (flat.triangles.empty()) {
    throw InputError(request.where, "scene {}: has no surface of {} to drive on that is less than 60 degrees steep",
                     scene.name, classNames);
  }
  const FreeSurface surface(probe, classes);
  RandomNumbers random(seed, name);
  std::vector<Vec3d> longest;
  for (int i = 0; i < kMostStarts; ++i) {
    const std::optional<State> start = startAt(surface, samplePoint(flat, random), random);
    if (!start) continue;
    const std::vector<Vec3d> path = PathSearch(surface, request, random).longestPath(*start);
    if (path.size() > longest.size()) longest = path;
    if (static_cast<double>(longest.size()) - 1 >= request.length / kArcLength) return longest;
  }
  const double longestLength = longest.empty() ? 0 : static_cast<double>(longest.size() - 1) * kArcLength;
  constexpr double kSmallScene = 20;  // m, size below which the unit of the scene may be wrong
  const Vec3d size = probe.bounds().high - probe.bounds().low;
  throw InputError(request.where,
                   "scene {}: the longest drive that was found on {} is {:g} m, but {:.4g} m are needed: "
                   "take fewer frames, a lower speed, or more classes{}",
                   scene.name, classNames, longestLength, request.length,
                   std::max(size.x, size.y) > kSmallScene
                       ? ""
                       : fmt::format("; the scene measures {:.3g} x {:.3g} m: is its `unit` right?", size.x, size.y));
}

}  // namespace scanmill
