// Places objects beside roads: lamps, signs, furniture, shelters, guard rails, and wooden poles with their wires.

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "town/lanes.h"
#include "town/placer.h"

namespace scanmill::town {
namespace {

using models::Fencing;
using models::Furnishing;
using models::Kind;
using models::SurfaceIndex;
using models::TrafficSign;
using models::UtilityPole;

// The part of a road along which objects may be placed (m along the road).
struct FurnishedRoad {
  const Road& road;
  double from, to;
};

// Returns the parts of roads along which objects may be placed. Minor roads have none.
std::vector<FurnishedRoad> furnishedRoads(const Layout& l) {
  std::vector<FurnishedRoad> parts;
  for (const Road& road : l.roads()) {
    if (road.minor) continue;
    parts.push_back(road.main ? FurnishedRoad{road, l.mainFrom, l.mainTo} : FurnishedRoad{road, 10, road.length() - 3});
  }
  return parts;
}

// Tries to place `per100m` objects per 100 m of each road that is not minor. For each object, calls tryPlace(draw,
// road, along, side) at most kTries times, until it returns true. `along` (m), `side` (1: left, -1: right): random.
template <class TryPlace>
void placeAlongRoads(const Layout& l, Kind kind, double per100m, const TryPlace& tryPlace) {
  for (const FurnishedRoad& part : furnishedRoads(l)) {
    Draw draw(l.seed, kind, part.road.number);
    const int count = static_cast<int>(per100m * std::max(0.0, part.to - part.from) / 100 + draw.next());
    for (int k = 0; k < count; ++k) {
      bool placed = false;
      for (int attempt = 0; attempt < Placer::kTries && !placed; ++attempt) {
        const double along = draw.in(part.from, part.to);
        placed = tryPlace(draw, part.road, along, draw.chance(0.5) ? 1 : -1);
      }
    }
  }
}

// Returns the spot `out` m beyond the road's edge; nullopt if another road, a parking lot, a square or water is there.
std::optional<Spot> beyondEdge(const Layout& l, const Road& road, double along, int side, double out) {
  const Spot spot = besideRoad(road, along, side * (road.section.half + out));
  if (l.besideAt(spot.at).edge <= out - 0.25 || l.areas.outsideHard(spot.at) <= 0.3) return std::nullopt;
  return spot;
}

// Places lamps at one side of each road that is not minor, evenly spaced, with the arms over the road.
void placeLamps(Placer& placer, const std::vector<Model>& lamps) {
  const Layout& l = placer.layout;
  constexpr double kHalfPost = 0.12;  // m; only the post needs free ground, not the arm above
  for (const FurnishedRoad& s : furnishedRoads(l)) {
    Draw draw(l.seed, Kind::RoadLamps, s.road.number);
    const double spacing = l.character.country ? draw.in(60, 120) : draw.in(16, 30);
    const int side = draw.chance(0.5) ? 1 : -1;
    const Model& lamp = draw.itemOf(lamps);
    int number = 0;
    for (const double at : models::steps(s.from + draw.in(3, spacing), s.to, spacing)) {
      std::optional<Spot> spot = beyondEdge(l, s.road, at, side, s.road.section.curb + 0.45);
      if (!spot) continue;
      spot->yaw += -side * kPi / 2;
      if (!placer.isFree(Footprint::square(spot->at, kHalfPost + Placer::kGap, spot->yaw))) continue;
      placer.occupancy.add(Footprint::square(spot->at, kHalfPost, spot->yaw));
      placer.put(lamp, *spot, fmt::format("lamp {}.{}", s.road.number + 1, ++number));
    }
  }
}

// Places signs along roads and at the mouths of side roads, facing the traffic. `signs`: models, by TrafficSign.
void placeSigns(Placer& placer, const std::vector<Model>& signs) {
  const Layout& l = placer.layout;
  const auto modelOf = [&](TrafficSign sign) -> const Model& { return signs[static_cast<std::size_t>(sign)]; };
  constexpr std::array kAlongRoads{TrafficSign::SpeedLimit, TrafficSign::Warning, TrafficSign::Priority,
                                   TrafficSign::Parking};
  const double per100m = l.character.country ? 1.5 : 5;
  placeAlongRoads(l, Kind::RoadSigns, per100m, [&](Draw& draw, const Road& road, double along, int side) {
    std::optional<Spot> spot = beyondEdge(l, road, along, side, road.section.curb + draw.in(0.35, 0.7));
    if (!spot) return false;
    // At the right of the road's line, vehicles drive in the direction of the line.
    spot->yaw += (side < 0 ? kPi : 0) + draw.in(-0.15, 0.15);
    const Model& sign = modelOf(draw.itemOf(kAlongRoads));
    return placer.tryNumbered("sign", [&](const std::string& name) { return placer.tryPut(sign, *spot, name); });
  });
  for (const Road& road : l.roads()) {
    const std::optional<TrafficSign> rule = signAtMouth(l, road);
    if (!rule) continue;
    for (const double back : {1.0, 2.5, 4.0, 6.0}) {
      const std::optional<Spot> spot = beyondEdge(l, road, laneStart(l) + back, 1, road.section.curb + 0.5);
      if (spot && placer.tryPut(modelOf(*rule), *spot, fmt::format("sign at a mouth {}", road.number))) break;
    }
  }
}

// Places bus shelters on wide pavements, with the open side towards the road.
void placeShelters(Placer& placer) {
  constexpr double kRoom = 2.4;  // m, least width of verge and sidewalk
  const Layout& l = placer.layout;
  const Model shelter = models::makeShelter(placer.builder, l.seed);
  placeAlongRoads(l, Kind::Shelters, 0.5, [&](Draw&, const Road& road, double along, int side) {
    if (road.section.verge + road.section.sidewalk < kRoom) return false;
    std::optional<Spot> spot = beyondEdge(l, road, along, side, road.section.outer() - 0.9);
    if (!spot) return false;
    spot->yaw += side > 0 ? 0 : kPi;
    return placer.tryNumbered("shelter", [&](const std::string& name) { return placer.tryPut(shelter, *spot, name); });
  });
}

// Places bins, benches, boxes and the like near the curb or at the outer edge of the sidewalk.
void placeFurniture(Placer& placer, const std::vector<Model>& furnishings) {
  const Layout& l = placer.layout;
  placeAlongRoads(
      l, Kind::RoadFurniture, l.character.clutter, [&](Draw& draw, const Road& road, double along, int side) {
        const bool nearCurb = draw.chance(0.5);
        const double out = nearCurb ? road.section.curb + draw.in(0.3, 0.6) : road.section.outer() + draw.in(-0.5, 1.5);
        std::optional<Spot> spot = beyondEdge(l, road, along, side, out);
        if (!spot) return false;
        spot->yaw += (side > 0 ? 0 : kPi) + draw.in(-0.3, 0.3);
        const Model& m = draw.itemOf(furnishings);
        return placer.tryNumbered("furniture", [&](const std::string& name) { return placer.tryPut(m, *spot, name); });
      });
}

constexpr double kRailPanel = 2;  // m, length of a panel

enum class Faces { Left, Right };  // side of the main road's line to which panels face

// Places panels over the interval `along` (m) of the main road, `lateral` m to the left of the road's line.
void placeRow(Placer& placer, const Model& panel, const models::Span& along, double lateral, Faces faces,
              double heightFactor, const std::string& name) {
  const Road& road = placer.layout.mainRoad();
  int number = 0;
  for (const double start : models::steps(along.low, along.high, kRailPanel)) {
    const Spot middle = besideRoad(road, start + kRailPanel / 2, lateral);
    const Point2 first = besideRoad(road, start, lateral).at;
    const Point2 last = besideRoad(road, start + kRailPanel, lateral).at;
    Affine pose = models::at(placer.layout.onGround(middle.at, -0.03), middle.yaw + (faces == Faces::Left ? kPi : 0));
    pose.linear = pose.linear * Mat3::scale({distance(first, last) / kRailPanel, 1, heightFactor});
    placer.builder.place(panel.mesh, placer.worldFromTown * pose, fmt::format("{} {}", name, ++number));
    placer.occupancy.add({middle.at, kRailPanel / 2, 0.2, middle.yaw});
  }
}

constexpr double kMostBetweenPoles = 60;  // m, largest distance between two poles that a wire connects
constexpr double kMostToHouse = 26;       // m, largest distance between a pole and a house that a wire connects

// Adds a wire between two points as a parabola, which is close to a catenary. `sag`: sag (m) in the middle of the wire.
void addWire(models::Shape& s, SurfaceIndex surface, const Vec3d& a, const Vec3d& b, double sag, double radius) {
  constexpr int kPieces = 16;
  std::vector<Vec3d> points;
  for (int k = 0; k <= kPieces; ++k) {
    const double t = static_cast<double>(k) / kPieces;
    Vec3d p = a + (b - a) * t;
    p.z -= 4 * sag * t * (1 - t);
    points.push_back(p);
  }
  s.pipe(surface, points, std::vector<double>(points.size(), radius), 5);
}

struct PlacedPole {
  Affine pose;       // in the town's frame
  double along = 0;  // m along the road
};

// True if a straight wire from `a` to `b` is at least kClear above each road that it crosses: lorries can pass.
bool passesAbove(const Layout& l, const Vec3d& a, const Vec3d& b) {
  constexpr double kClear = 5;  // m, least height of a wire above a road
  constexpr int kSamples = 24;
  for (int k = 0; k <= kSamples; ++k) {
    const Vec3d p = a + (b - a) * (static_cast<double>(k) / kSamples);
    const Beside beside = l.besideAt({p.x, p.y});
    if (beside.nearRoad && beside.edge < 0.5 && p.z < l.heightAt({p.x, p.y}) + kClear) return false;
  }
  return true;
}

// Places poles behind the pavement at one side of the main road, evenly spaced but away from objects, and returns them.
std::vector<PlacedPole> placePoles(Placer& placer, Draw& draw, const UtilityPole& pole) {
  const Layout& l = placer.layout;
  const Road& road = l.mainRoad();
  const double side = draw.sign();
  const double spacing = draw.in(32, 48);
  std::vector<PlacedPole> poles;
  const double out = road.section.outer() + 0.45;  // m beyond the road's edge
  for (const double ideal : models::steps(l.mainFrom - 40 + draw.in(0, spacing), l.mainTo + 40, spacing)) {
    for (const double shift : {0.0, 2.5, -2.5, 5.0, -5.0, 8.0, -8.0}) {
      const double along = ideal + shift;
      if (along < 4 || along > road.length() - 4) continue;
      const Spot spot = besideRoad(road, along, side * (road.section.half + out));
      const Beside b = l.besideAt(spot.at);
      if (!b.nearRoad || b.edge < out - 0.25 || l.areas.outsideHard(spot.at) < 0.3) continue;
      if (!placer.isFree(Footprint::square(spot.at, 0.35, spot.yaw))) continue;
      placer.occupancy.add(Footprint::square(spot.at, 0.25, spot.yaw));
      placer.put(pole.model, spot, fmt::format("utility pole {}", poles.size() + 1));
      poles.push_back({models::at(l.onGround(spot.at), spot.yaw), along});
      break;
    }
  }
  return poles;
}

}  // namespace

std::optional<TrafficSign> signAtMouth(const Layout& l, const Road& road) {
  Draw draw(l.seed, Kind::MouthSign, road.number);
  const TrafficSign sign = draw.chance(0.3) ? TrafficSign::Stop : TrafficSign::GiveWay;
  if (!road.joins || road.minor || !road.against || draw.chance(0.3)) return std::nullopt;
  return sign;
}

// Places lamps, signs, shelters and furniture, in this order, after all their models have been built.
void placeFixtures(Placer& placer) {
  const std::vector<Model> lamps = placer.forms(2, models::makeLamp);
  const auto signs = placer.forms(models::kSigns, [](SceneBuilder& builder, std::uint64_t seed, int form) {
    return models::makeSign(builder, seed, static_cast<TrafficSign>(form), form);
  });
  const auto furnishings =
      placer.forms(static_cast<int>(Furnishing::Count), [](SceneBuilder& builder, std::uint64_t seed, int form) {
        return models::makeFurnishing(builder, seed, static_cast<Furnishing>(form));
      });
  placeLamps(placer, lamps);
  placeSigns(placer, signs);
  if (!placer.layout.character.country) placeShelters(placer);
  placeFurniture(placer, furnishings);
}

// Places guard rails and noise barriers along motorways.
void placeRails(Placer& placer) {
  const Layout& l = placer.layout;
  const Road& road = l.mainRoad();
  if (!l.character.motorway || road.section.median <= 0) return;
  Draw draw(l.seed, Kind::Rails);
  const auto panel = [&](Fencing kind) { return models::makeFencePanel(placer.builder, l.seed, kind); };
  const Model rail = panel(Fencing::GuardRail);
  const double length = road.length();
  if (draw.chance(0.5)) {
    placeRow(placer, panel(Fencing::Barrier), {2, length - 2}, 0, Faces::Right, 1, "median barrier");
  } else {
    placeRow(placer, rail, {2, length - 2}, 0.15, Faces::Left, 1, "median rail to the left");
    placeRow(placer, rail, {2, length - 2}, -0.15, Faces::Right, 1, "median rail to the right");
  }
  for (const bool left : {false, true}) {
    const double side = left ? 1 : -1;
    const Faces inwards = left ? Faces::Right : Faces::Left;
    const double edge = road.section.half + 0.6;
    const double begin = draw.in(2, 60);
    const double end = length - draw.in(2, 60);
    placeRow(placer, rail, {begin, end}, side * edge, inwards, 1, left ? "left rail" : "right rail");
    if (!draw.chance(0.4)) continue;
    const double barrierBegin = draw.in(10, length / 2);
    const double barrierEnd = barrierBegin + draw.in(60, length / 2 - 12);
    const double beyondRail = draw.in(2.5, 5);
    const double heightFactor = draw.in(1.6, 2.4);
    placeRow(placer, panel(Fencing::Boards), {barrierBegin, barrierEnd}, side * (edge + beyondRail), inwards,
             heightFactor, left ? "left noise barrier" : "right noise barrier");
  }
}

// Places poles in some towns, wires between successive poles, and wires from most houses to the nearest pole.
void placeWires(Placer& placer) {
  const Layout& l = placer.layout;
  Draw draw(l.seed, Kind::Wire);
  const Character& c = l.character;
  // Terraced districts, motorways and plain towns have no poles: wires are underground, or there is no space.
  const double probability = c.farmland ? 0.7 : c.terraced || c.motorway || c.plain ? 0 : 0.4;
  if (!draw.chance(probability)) return;
  constexpr double kPowerRadius = 0.006, kTelephoneRadius = 0.011, kHouseRadius = 0.008;  // m, radii of the wires
  constexpr double kSagToHouse = 0.015;    // sag of a wire to a house, divided by the distance to the pole
  constexpr double kAtWallPerFloor = 2.7;  // m, height at which wires reach a house, per floor: below the eaves
  constexpr double kBeforeWall = 0.02;     // m between the end of a wire and the front wall
  const UtilityPole pole = models::makeUtilityPole(placer.builder, l.seed);
  const std::vector<PlacedPole> poles = placePoles(placer, draw, pole);
  const double slack = draw.in(0.00025, 0.0005);  // 1/m, sag divided by the square of the distance between poles
  for (std::size_t i = 1; i < poles.size(); ++i) {
    const double distance = poles[i].along - poles[i - 1].along;
    if (distance > kMostBetweenPoles) continue;
    const double sag = slack * distance * distance;
    const Affine &from = poles[i - 1].pose, &to = poles[i].pose;
    models::Shape s(placer.builder, fmt::format("wires {}", i));
    const SurfaceIndex rubber = s.surface("object", "rubber");
    for (const Vec3d& p : pole.insulators) addWire(s, rubber, from * p, to * p, sag, kPowerRadius);
    addWire(s, rubber, from * pole.telephone, to * pole.telephone, sag, kTelephoneRadius);
    placer.putShape(s);
  }
  for (const models::House& house : l.houses) {
    if (poles.empty() || !draw.chance(0.7)) continue;
    const Vec3d atWall =
        house.pose * Vec3d{draw.in(0.2, 0.8) * house.width, -kBeforeWall, kAtWallPerFloor * house.floors};
    const auto distance = [&](const PlacedPole& p) { return length(p.pose.translation - atWall); };
    const PlacedPole& nearest = *std::ranges::min_element(poles, {}, distance);
    const Vec3d start = nearest.pose * pole.telephone;
    if (distance(nearest) > kMostToHouse || !passesAbove(l, start, atWall)) continue;
    models::Shape s(placer.builder, fmt::format("wire to house {}", house.number + 1));
    addWire(s, s.surface("object", "rubber"), start, atWall, kSagToHouse * distance(nearest), kHouseRadius);
    placer.putShape(s);
  }
}

}  // namespace scanmill::town
