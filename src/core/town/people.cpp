// Places pedestrians, and parked bicycles and motorcycles beside roads.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "base/path.h"
#include "town/lanes.h"
#include "town/placer.h"

namespace scanmill::town {
namespace {

using models::Kind;

// A position on a pavement, or beside a road that has no pavement.
struct PavementPosition {
  const Road* road = nullptr;
  double along = 0;      // m along the road's line
  double lateral = 0;    // m to the left of the line
  double direction = 1;  // direction of walking: 1 along the line, -1 against it

  Spot spot() const {
    Spot s = besideRoad(*road, along, lateral);
    s.yaw += direction < 0 ? kPi : 0;
    return s;
  }
};

// Returns a random position for people, mostly along the main road; nullopt if the drawn position is on a road.
std::optional<PavementPosition> drawPosition(const Placer& placer, Draw& draw) {
  const Layout& l = placer.layout;
  const Road& road = draw.chance(0.7) ? l.mainRoad() : draw.itemOf(l.roads());
  const CrossSection& s = road.section;
  const double along = road.main ? draw.in(l.mainFrom, l.mainTo) : draw.in(10, road.length());
  const double out =
      s.sidewalk > 0 ? s.curb + s.verge + draw.in(0.3, std::max(0.4, s.sidewalk - 0.3)) : draw.in(0.4, 1);
  const double side = draw.sign();
  const PavementPosition position{&road, along, side * (s.half + out), draw.sign()};
  return l.besideAt(position.spot().at).edge > 0.2 ? std::optional(position) : std::nullopt;
}

constexpr double kLongestFree = 110;  // m, largest result of freeLength()

// Returns how far (m) a pedestrian or cyclist can go from a position until an object, another road or the end of the
// road; at most kLongestFree. `half`: half of the width that must be free (m); 0.2 m may extend over a road.
double freeLength(const Placer& placer, PavementPosition position, double half) {
  constexpr double kNearEnd = 20;      // m from the ends of the main road, where vehicles emerge from below ground
  constexpr double kFromRoadEnd = 4;   // m
  constexpr double kFarthestOut = 12;  // m from a road's edge; farther out, the position is off the pavement
  const std::vector<Point2>& line = placer.layout.mainRoad().line;
  const double start = position.along;
  for (const double done : models::steps(0, kLongestFree, 0.5)) {
    position.along = start + position.direction * done;
    if (position.along < kFromRoadEnd || position.along > position.road->length() - kFromRoadEnd) return done;
    const Spot spot = position.spot();
    if (std::min(distance(spot.at, line.front()), distance(spot.at, line.back())) < kNearEnd) return done;
    const double edge = placer.layout.besideAt(spot.at).edge;
    if (edge < half - 0.2 || edge > kFarthestOut) return done;
    if (!placer.occupancy.isFree(Footprint::square(spot.at, half, spot.yaw))) return done;
  }
  return kLongestFree;
}

constexpr double kPiece = 3;  // m between the points of a path on a pavement

// Returns the points of a pedestrian's path in the world's frame: to the end of the free length and back, `laps` times.
// The way back is 2 * kAside beside the way there.
std::vector<Vec3d> walkingPath(const Placer& placer, const PavementPosition& start, double freeLength, int laps) {
  constexpr double kAside = 0.15;  // m from the middle of the free ground
  constexpr double kTurn = 0.25;   // m from the start of a turn to the end of the free ground
  const auto pieces = static_cast<int>(freeLength / kPiece);
  std::vector<Vec3d> points;
  const auto add = [&](double piece, double lateral) {
    PavementPosition position = start;
    position.along += position.direction * freeLength * piece / pieces;
    position.lateral += position.direction * lateral;
    points.push_back(placer.worldFromTown * placer.layout.onGround(position.spot().at));
  };
  const double turn = kTurn * pieces / freeLength;  // kTurn in units of pieces
  for (int lap = 0; lap < laps; ++lap) {
    for (int k = 0; k < pieces; ++k) add(k + turn, -kAside);
    add(pieces - turn, -kAside);
    add(pieces, 0);
    for (int k = pieces; k > 0; --k) add(k - turn, kAside);
    add(turn, kAside);
    add(0, 0);
  }
  return points;
}

// Places a pedestrian who walks to and fro along a road. Returns false without a position or enough free length.
bool placeWalker(Placer& placer, Draw& draw, const models::Walker& walker, const std::string& name) {
  constexpr double kLeast = 12;           // m, least free length
  constexpr double kHalfWidth = 0.4;      // m, half of the width of the free ground
  constexpr double kLeastDuration = 120;  // s, time that the path must last
  const std::optional<PavementPosition> start = drawPosition(placer, draw);
  const double speed = draw.in(1.0, 1.6);
  if (!start) return false;
  const double length = freeLength(placer, *start, kHalfWidth);
  if (length < kLeast) return false;
  const auto laps = static_cast<int>(std::ceil(speed * kLeastDuration / (2 * length)));
  const auto path = std::make_shared<const Path>(walkingPath(placer, *start, length, laps));
  const auto pieces = static_cast<int>(length / kPiece);
  for (int k = 0; k < pieces; ++k) {
    PavementPosition middle = *start;
    middle.along += middle.direction * length * (k + 0.5) / pieces;
    const Spot spot = middle.spot();
    placer.occupancy.add({spot.at, length / pieces / 2, kHalfWidth, spot.yaw});
  }
  const auto animation = std::make_shared<Animation>();
  for (const Model& m : walker.moments) animation->meshes.push_back(m.mesh);
  animation->period = walker.stride / speed;
  animation->until = path->length() / speed;
  placer.putMoving(walker.moments.front().mesh, name, std::make_shared<const Movement>(path, 0, speed), animation);
  return true;
}

// Places a cyclist who rides along a pavement to the end of the free length. Returns false as placeWalker() does.
bool placeCyclist(Placer& placer, Draw& draw, const Model& bicycle, const Model& rider, const std::string& name) {
  constexpr double kLeast = 20;  // m, least free length
  const std::optional<PavementPosition> start = drawPosition(placer, draw);
  const double speed = draw.in(2, 4);
  if (!start) return false;
  const double length = freeLength(placer, *start, 0.7);
  if (length < kLeast) return false;
  std::vector<Vec3d> points;
  PavementPosition position = *start;
  for (const double done : models::steps(1.5, length - 1.5, kPiece)) {
    position.along = start->along + start->direction * done;
    const Spot spot = position.spot();
    placer.occupancy.add({spot.at, kPiece / 2 + 0.9, 0.5, spot.yaw});
    points.push_back(placer.worldFromTown * placer.layout.onGround(spot.at));
  }
  const auto path = std::make_shared<const Path>(points);
  const auto movement = std::make_shared<const Movement>(path, draw.in(0, 0.7) * path->length(), speed);
  placer.putMoving(bicycle.mesh, name, movement);
  placer.putMoving(rider.mesh, "rider of " + name, movement);
  return true;
}

// Tries at most kTries random positions for a standing person; the person stands at the first position that is free.
void placeStandingPerson(Placer& placer, Draw& draw, const Model& person, const std::string& name) {
  for (int attempt = 0; attempt < Placer::kTries; ++attempt) {
    const std::optional<PavementPosition> position = drawPosition(placer, draw);
    if (!position) continue;
    Spot spot = position->spot();
    spot.yaw += draw.in(-0.3, 0.3);
    if (placer.tryPut(person, spot, name)) return;
  }
}

// Places 1 to `most` bicycles or motorcycles, named "NAME.1", "NAME.2" ...: side by side across the pavement or, on
// narrow pavements, one behind the other. `lean`: roll of a parked vehicle (rad).
void placeParkedRow(Placer& placer, Draw& draw, const std::vector<Model>& forms, const std::string& name, double lean,
                    int most) {
  constexpr double kApart = 0.75, kApartAlong = 2.2;  // m between neighbours across and along the pavement
  constexpr double kWide = 2.6;                       // m; on narrower sidewalks, vehicles are one behind the other
  constexpr double kFromWalls = 1.1;                  // m from the row's middle to the outer edge; pedestrians can pass
  for (int attempt = 0; attempt < Placer::kTries; ++attempt) {
    std::optional<PavementPosition> position = drawPosition(placer, draw);
    if (!position) continue;
    const CrossSection& s = position->road->section;
    const bool across = s.sidewalk > kWide;
    if (across) position->lateral = std::copysign(s.half + s.outer() - kFromWalls, position->lateral);
    const int count = 1 + draw.below(most);
    int placed = 0;
    for (; placed < count; ++placed) {
      Spot spot = position->spot();
      const bool onRoad = placer.layout.besideAt(spot.at).edge < 0.3;
      if (onRoad || position->along > position->road->length() - 3) break;
      spot.yaw += (across ? kPi / 2 : 0) + draw.in(-0.08, 0.08);
      spot.lean = lean;
      if (!placer.tryPut(draw.itemOf(forms), spot, fmt::format("{}.{}", name, placed + 1))) break;
      position->along += across ? kApart : kApartAlong;
    }
    if (placed > 0) return;
  }
}

// Places pedestrians. Every third pedestrian stands, as do pedestrians for whom no free length is found.
void placePedestrians(Placer& placer, int count) {
  constexpr int kWalkers = 5, kStanding = 4;  // numbers of models
  const auto walking = placer.forms(std::min(count, kWalkers), models::makeWalker);
  const auto standing = placer.forms(std::min((count + 2) / 3, kStanding), models::makePedestrian);
  for (int i = 0; i < count; ++i) {
    Draw draw(placer.layout.seed, Kind::Pedestrian, i);
    const std::string name = fmt::format("pedestrian {}", i + 1);
    const bool stands = i % 3 == 2;
    const models::Walker& walker = walking[static_cast<std::size_t>(i) % walking.size()];
    bool walks = false;
    for (int attempt = 0; attempt < Placer::kTries && !stands && !walks; ++attempt) {
      walks = placeWalker(placer, draw, walker, name);
    }
    const auto form = static_cast<std::size_t>(stands ? i / 3 : i) % standing.size();
    if (!walks) placeStandingPerson(placer, draw, standing[form], name);
  }
}

void placeSidewalkCyclists(Placer& placer, int count) {
  constexpr int kCyclists = 3;  // number of models
  const auto makeCyclist = [](SceneBuilder& builder, std::uint64_t seed, int form) {
    return models::makeCyclist(builder, seed, kRoadCyclistForms + form);
  };
  const auto riding = placer.forms(std::min(count, kCyclists), makeCyclist);
  for (int i = 0; i < count; ++i) {
    Draw draw(placer.layout.seed, Kind::SidewalkCyclist, i);
    const auto& [bicycle, rider] = riding[static_cast<std::size_t>(i) % riding.size()];
    for (int attempt = 0; attempt < Placer::kTries; ++attempt) {
      if (placeCyclist(placer, draw, bicycle, rider, fmt::format("cyclist's bicycle on the sidewalk {}", i + 1))) break;
    }
  }
}

}  // namespace

void placePeople(Placer& placer) {
  const Layout& l = placer.layout;
  if (l.character.motorway) return;
  const double length = l.mainTo - l.mainFrom;
  Draw counts(l.seed, Kind::PeopleCounts);
  // Returns a random number of people or vehicles of a kind: at least 1, or 0 if the parameter `people` is 0.
  const auto drawCount = [&](double share) {
    const int count = static_cast<int>(share * l.character.people * length / 100 + counts.next());
    return l.parameters.people > 0 ? std::max(1, count) : 0;
  };
  const int pedestrians = drawCount(1);
  const int bicycles = drawCount(0.6);
  const int motorcycles = drawCount(0.6);
  const int cyclists = drawCount(2);
  placePedestrians(placer, pedestrians);
  const auto bicycleForms = placer.forms(std::min(bicycles, 4), models::makeBicycle, nullptr);
  for (int i = 0; i < bicycles; ++i) {
    Draw draw(l.seed, Kind::ParkedBicycles, i);
    const double lean = radians(draw.in(-9, -5));
    placeParkedRow(placer, draw, bicycleForms, fmt::format("bicycle {}", i + 1), lean, 8);
  }
  placeSidewalkCyclists(placer, cyclists);
  const auto motorcycleForms = placer.forms(std::min(motorcycles, 2), models::makeMotorcycle, nullptr);
  for (int i = 0; i < motorcycles; ++i) {
    Draw draw(l.seed, Kind::ParkedMotorcycles, i);
    placeParkedRow(placer, draw, motorcycleForms, fmt::format("motorcycle {}", i + 1), radians(8), 4);
  }
}

}  // namespace scanmill::town
