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

constexpr double kCell = 0.25;       // cell size of the cached heights (m)
constexpr double kAboveOrBelow = 1;  // a surface at most this far above or below a tested position is found (m)
constexpr double kClear = 2.5;       // free height that a vehicle needs above the surface (m)
constexpr double kHalfWidth = 1;     // half of a vehicle's width (m)
constexpr double kHalfLength = 2;    // half of a vehicle's length (m)
constexpr double kArcLength = 4;     // length of an arc (m); a path consists of such arcs
constexpr double kTightest = 6;      // minimum radius of an arc (m)
// Distance (m) from the vehicle's middle to the edge of the road, on the side where the vehicle drives.
constexpr double kFromEdge = 2;
// If the edge is at least this far away (m), the surface counts as an open place, not as a road.
constexpr double kOpen = 12;
// Path length (m) after which a vehicle in an open place chooses again whether to turn.
constexpr double kWishLasts = 24;
constexpr double kTurns = 0.4;        // probability that a vehicle in an open place chooses to turn
constexpr int kLook = 12;             // distance that is tested beyond the end of an arc (m)
constexpr int kStarts = 24;           // maximum number of starting points that are tried
constexpr int kMostTurnsBack = 2000;  // maximum number of backtracking steps of a search

// Weights of the terms of an arc's cost, of which only the ratios matter.
constexpr double kBendCost = 0.3;     // of the squared bend (kTightest times the curvature)
constexpr double kChangeCost = 1.5;   // of the squared change of the bend
constexpr double kVisitCost = 3;      // of each earlier visit of the path to the spot ahead
constexpr double kWishCost = 8;       // of the difference from the wished bend in an open place; half beside one edge
constexpr double kWishedBend = 0.75;  // bend of a turn in an open place

// Position (m, world frame) and heading (rad) of a vehicle.
struct State {
  Vec3d position;
  double yaw = 0;

  // Returns the state after driving `metres` along an arc of this curvature (rad/m, positive to the left).
  State on(double metres, double curvature) const {
    const double middle = yaw + curvature * metres / 2;
    const double bend = curvature * metres / 2;
    const double chord = std::fabs(bend) < 1e-9 ? metres : metres * std::sin(bend) / bend;
    return {position + Vec3d{std::cos(middle), std::sin(middle), 0} * chord, yaw + curvature * metres};
  }
  Vec3d left(double metres) const { return position + Vec3d{-std::sin(yaw), std::cos(yaw), 0} * metres; }
};

// Finds where surfaces of given classes are free of obstacles. Caches the results in cells.
class FreeSurface {
 public:
  FreeSurface(const SceneProbe& probe, std::vector<std::uint16_t> classes)
      : probe_(probe), classes_(std::move(classes)) {}

  // Returns the height of the surface at a position (m). Returns nothing if there is no surface of the given classes at
  // most about 1.5 m above or below the position, or if something is less than kClear above the surface.
  std::optional<double> height(const Vec3d& position) const {
    const auto cell = [](double d) { return static_cast<std::int64_t>(std::floor(d / kCell)); };
    const auto layer = static_cast<std::int64_t>(std::floor(position.z));
    const std::tuple key{cell(position.x), cell(position.y), layer};
    if (const auto known = known_.find(key); known != known_.end()) return known->second;
    const Vec3d middle{(static_cast<double>(std::get<0>(key)) + 0.5) * kCell,
                       (static_cast<double>(std::get<1>(key)) + 0.5) * kCell, static_cast<double>(layer) + 0.5};
    return known_[key] = look(middle);
  }

  // Returns the height of the surface under the vehicle's middle (m); nothing if a vehicle has no room in this state.
  std::optional<double> room(const State& s) const {
    const std::optional<double> middle = height(s.position);
    if (!middle || !height(s.left(kHalfWidth)) || !height(s.left(-kHalfWidth))) return std::nullopt;
    return middle;
  }

  // True if a vehicle can drive straight from one state to the other without touching an obstacle. Both states must
  // have room for a vehicle and be less than a few metres apart.
  bool passes(const State& from, const State& to) const {
    std::vector<SceneProbe::Ray> rays;
    double reach = 0;
    for (const double side : {-kHalfWidth, 0.0, kHalfWidth}) {
      for (const double up : {0.5, 1.5}) {
        const Vec3d start = from.left(side) + Vec3d{0, 0, up};
        const Vec3d step = to.left(side) + Vec3d{0, 0, up} - start;
        const double far = length(step);
        if (far < kCell) continue;
        rays.push_back({start, step * (1 / far)});
        reach = std::max(reach, far);
      }
    }
    const auto hits = probe_.first(rays, reach);
    return std::ranges::none_of(hits, [](const auto& hit) { return hit.has_value(); });
  }

  // Returns the state one metre further along an arc; nothing if a vehicle has no room there, or if an obstacle is
  // between the two states.
  std::optional<State> metreOn(const State& from, double curvature) const {
    State s = from.on(1, curvature);
    const std::optional<double> height = room(s);
    if (!height) return std::nullopt;
    s.position.z = *height;
    return passes(from, s) ? std::optional(s) : std::nullopt;
  }

  // Returns the distance from the vehicle's middle to the edge of the surface (m), at most kOpen. `side`: 1 for the
  // left side, -1 for the right side.
  double toEdge(const State& s, double side) const {
    double far = 0;
    while (far < kOpen && height(s.left(side * (far + kCell)))) far += kCell;
    return far;
  }

 private:
  std::optional<double> look(const Vec3d& middle) const {
    const double high = 0.5 + kAboveOrBelow;
    const auto below = probe_.first({middle + Vec3d{0, 0, high}, {0, 0, -1}}, 2 * high);
    if (!below || std::ranges::find(classes_, below->semantic) == classes_.end()) return std::nullopt;
    // The downward ray has already tested the space below its start; the upward ray tests the space above.
    const double over = below->position.z + kClear - (middle.z + high);
    if (over > 0 && probe_.first({middle + Vec3d{0, 0, high}, {0, 0, 1}}, over)) return std::nullopt;
    return below->position.z;
  }

  const SceneProbe& probe_;
  std::vector<std::uint16_t> classes_;
  mutable std::map<std::tuple<std::int64_t, std::int64_t, std::int64_t>, std::optional<double>> known_;
};

// A sequence of random numbers that depends on the seed and the drive's name.
class Draws {
 public:
  Draws(std::uint64_t seed, const std::string& name) {
    address_.seed = seed;
    address_.purpose = Purpose::RandomPath;
    // Like fnv1a(), but from 0: datasets depend on it.
    for (const char c : name) address_.scene = (address_.scene ^ static_cast<unsigned char>(c)) * 16777619u;
  }
  double next() {
    ++address_.frame;
    return uniform(randomBlock(address_)[0]);
  }
  // Returns a random number that depends only on `number`, the seed and the name, not on earlier calls.
  double at(std::uint32_t number) const {
    RandomAddress a = address_;
    a.frame = number;
    a.sensor = 1;
    return uniform(randomBlock(a)[0]);
  }

 private:
  RandomAddress address_;
};

// The triangles of the given classes that are less than 60 degrees steep. `sums` are the cumulative sums of their areas
// (m^2) projected onto the horizontal plane.
struct Floor {
  std::vector<std::array<Vec3d, 3>> triangles;
  std::vector<double> sums;
};

Floor floorOf(const Scene& scene, const std::vector<std::uint16_t>& classes) {
  Floor floor;
  double sum = 0;
  forEachTriangleOf(scene, classes, scene.instances.size(),
                    [&](std::uint32_t, std::uint32_t, const std::array<Vec3d, 3>& corner) {
                      const Vec3d square = cross(corner[1] - corner[0], corner[2] - corner[0]);
                      if (!(std::fabs(square.z) > length(square) / 2)) return;
                      sum += std::fabs(square.z) / 2;
                      floor.triangles.push_back(corner);
                      floor.sums.push_back(sum);
                    });
  return floor;
}

Vec3d placeOn(const Floor& floor, Draws& draws) {
  const double wanted = draws.next() * floor.sums.back();
  const auto found = std::upper_bound(floor.sums.begin(), floor.sums.end() - 1, wanted);
  const std::array<Vec3d, 3>& t = floor.triangles[static_cast<std::size_t>(found - floor.sums.begin())];
  const double root = std::sqrt(draws.next());
  const double v = draws.next();
  return t[0] * (1 - root) + t[1] * (root * (1 - v)) + t[2] * (root * v);
}

// A depth-first search over arcs, which tries the cheapest arc first.
class PathSearch {
 public:
  PathSearch(const FreeSurface& surface, const RandomPath& random, const Draws& draws)
      : surface_(surface), random_(random), draws_(draws) {}

  // Returns the points of the longest path from `start` that the search finds. The search ends when a path has the
  // length that `random` asks for, or after kMostTurnsBack steps back.
  std::vector<Vec3d> from(const State& start) {
    std::vector<Node> nodes{open({start, 0}, 0)};
    std::vector<Vec3d> longest;
    int turnsBack = 0;
    while (!nodes.empty() && turnsBack < kMostTurnsBack) {
      if (nodes.size() > longest.size()) {
        longest.clear();
        for (const Node& node : nodes) longest.push_back(node.at.state.position);
      }
      if (static_cast<double>(nodes.size() - 1) * kArcLength >= random_.length) break;
      Node& last = nodes.back();
      if (last.next == last.arcs.size()) {
        ++turnsBack;
        abandon(nodes.back());
        nodes.pop_back();
        continue;
      }
      nodes.push_back(open(last.arcs[last.next++].end, static_cast<double>(nodes.size()) * kArcLength));
    }
    return longest;
  }

 private:
  struct End {
    State state;
    double curvature;
  };
  struct Arc {
    End end;
    double cost;
  };
  struct Node {
    End at;
    std::vector<Arc> arcs;  // arcs that start at this node, the cheapest first
    std::size_t next = 0;
  };
  using Spot = std::tuple<std::int64_t, std::int64_t, std::int64_t, int>;

  // Returns a key that is equal for states of similar position and heading. `size`: size of a position cell (m).
  // `headings`: number of sectors into which headings are divided.
  static Spot spotOf(const State& s, double size, int headings) {
    const auto heading = static_cast<int>(std::lround(s.yaw / (2 * kPi) * headings));
    return {std::llround(s.position.x / size), std::llround(s.position.y / size), std::llround(s.position.z / kClear),
            ((heading % headings) + headings) % headings};
  }
  static Spot widely(const State& s) { return spotOf(s, kLook, 8); }
  static Spot closely(const State& s) { return spotOf(s, 1, 24); }

  void abandon(const Node& node) {
    --visits_[widely(node.at.state)];
    deadEnds_.insert(closely(node.at.state));
  }

  Node open(const End& at, double driven) {
    ++visits_[widely(at.state)];
    Node node{at, {}};
    const auto wish = static_cast<std::uint32_t>(driven / kWishLasts);
    const double turn = draws_.at(wish);
    const double wished = turn < kTurns / 2       ? kWishedBend / kTightest
                          : turn < 1 - kTurns / 2 ? 0
                                                  : -kWishedBend / kTightest;
    for (int k = -4; k <= 4; ++k) {
      const double curvature = k / (4 * kTightest);
      if (const std::optional<Arc> arc = arcOf(at, curvature, wished)) node.arcs.push_back(*arc);
    }
    std::ranges::stable_sort(node.arcs, {}, &Arc::cost);
    return node;
  }

  // Returns the arc of this curvature (rad/m) that starts at `at`. Returns nothing if a vehicle has no room on the arc,
  // or if its end is known as a dead end. `wished`: curvature that the vehicle prefers in open places.
  std::optional<Arc> arcOf(const End& at, double curvature, double wished) const {
    State s = at.state;
    for (int i = 0; i < static_cast<int>(kArcLength); ++i) {
      const std::optional<State> next = surface_.metreOn(s, curvature);
      if (!next) return std::nullopt;
      s = *next;
    }
    if (deadEnds_.contains(closely(s))) return std::nullopt;
    const double bend = kTightest * curvature;
    const double change = kTightest * (curvature - at.curvature);
    double cost = kBendCost * bend * bend + kChangeCost * change * change;
    // Rate the end of the arc and two points straight ahead of it, since rating the end alone makes the path oscillate.
    for (const double ahead : {0.0, 4.0, 8.0}) cost += offSide(s.on(ahead, 0), curvature, wished);
    const auto [far, end] = lookAhead(s);
    if (const auto visits = visits_.find(widely(end)); visits != visits_.end()) cost += kVisitCost * visits->second;
    cost += kLook - far;
    return Arc{{s, curvature}, cost};
  }

  // Returns the cost of a state. It grows with the lateral distance from the preferred line on the road. In open places
  // it grows with the difference between `curvature` and `wished` (rad/m). It is constant off the surface.
  double offSide(State s, double curvature, double wished) const {
    constexpr double kMost = 2;  // lateral distance (m) up to which the cost grows quadratically, then linearly
    const std::optional<double> height = surface_.height(s.position);
    if (!height) return 2 * kMost * kMost;
    s.position.z = *height;
    const double left = surface_.toEdge(s, 1);
    const double right = surface_.toEdge(s, -1);
    const bool lefty = random_.keep == RoadSide::Left;
    const double own = lefty ? left : right;
    if (left >= kOpen && right >= kOpen) return kWishCost * kTightest * std::fabs(curvature - wished);
    const double middle = (left + right) / 2;
    const double wanted = random_.keep == RoadSide::Middle ? middle : std::min(kFromEdge, middle);
    const double off = std::fabs(own - wanted);
    const double turns = own >= kOpen ? kWishCost / 2 * kTightest * std::fabs(curvature - wished) : 0;
    return (off < kMost ? off * off : kMost * (2 * off - kMost)) + turns;
  }

  // Tests five arcs that start at a state. Returns the longest distance (m, at most kLook) that a vehicle can drive on
  // one of them, and the state at its end.
  std::pair<double, State> lookAhead(const State& from) const {
    std::pair<double, State> farthest{0, from};
    for (const double bend : {0.0, 0.5, -0.5, 1.0, -1.0}) {
      State s = from;
      int far = 0;  // distance driven so far (m)
      for (; far < kLook; ++far) {
        const std::optional<State> next = surface_.metreOn(s, bend / kTightest);
        if (!next) break;
        s = *next;
      }
      if (far > farthest.first) farthest = {far, s};
      if (far == kLook) break;
    }
    return farthest;
  }

  const FreeSurface& surface_;
  const RandomPath& random_;
  const Draws& draws_;
  std::map<Spot, int> visits_;  // number of times that the current path has passed each spot
  std::set<Spot> deadEnds_;     // spots from which the search found no path of the required length
};

// Returns the state at `position` with the heading in which a vehicle can drive straight on farthest. Returns nothing
// if this distance is not longer than two arcs.
std::optional<State> startAt(const FreeSurface& surface, Vec3d position, Draws& draws) {
  std::optional<State> best;
  int farthest = 2 * static_cast<int>(kArcLength);
  const double first = draws.next() * 2 * kPi;
  for (int i = 0; i < 32; ++i) {
    const State heading{position, first + i * kPi / 16};
    std::optional<State> s =
        surface.room(heading) && surface.room(heading.on(-kHalfLength, 0)) ? std::optional(heading) : std::nullopt;
    int far = 0;  // distance driven so far (m)
    for (; s && far < 40; ++far) s = surface.metreOn(*s, 0);
    if (far <= farthest) continue;
    farthest = far;
    best = heading;
  }
  return best;
}

}  // namespace

std::vector<Vec3d> findRandomPath(const SceneProbe& probe, const RandomPath& random, std::uint64_t seed,
                                  const std::string& name) {
  const Scene& scene = probe.scene();
  const std::vector<std::uint16_t> classes = classIds(scene.ontology, random.classes, random.where);
  const std::string what = fmt::format("{}", fmt::join(random.classes, ", "));
  const Floor floor = floorOf(scene, classes);
  if (floor.triangles.empty()) {
    throw InputError(
        random.where,
        fmt::format("scene {}: has no surface of {} to drive on that is less than 60 degrees steep", scene.name, what));
  }
  const FreeSurface surface(probe, classes);
  Draws draws(seed, name);
  std::vector<Vec3d> longest;
  for (int i = 0; i < kStarts; ++i) {
    const std::optional<State> start = startAt(surface, placeOn(floor, draws), draws);
    if (!start) continue;
    const std::vector<Vec3d> path = PathSearch(surface, random, draws).from(*start);
    if (path.size() > longest.size()) longest = path;
    if (static_cast<double>(longest.size()) - 1 >= random.length / kArcLength) return longest;
  }
  const double found = longest.empty() ? 0 : static_cast<double>(longest.size() - 1) * kArcLength;
  constexpr double kSmall = 20;  // size (m) below which the unit of the scene may be wrong
  const Vec3d size = probe.bounds().high - probe.bounds().low;
  throw InputError(
      random.where,
      fmt::format("scene {}: the longest drive that was found on {} is {:g} m, but {:.4g} m are needed: "
                  "take fewer frames, a lower speed, or more classes{}",
                  scene.name, what, found, random.length,
                  std::max(size.x, size.y) > kSmall
                      ? ""
                      : fmt::format("; the scene measures {:.3g} x {:.3g} m: is its `unit` right?", size.x, size.y)));
}

}  // namespace scanmill
