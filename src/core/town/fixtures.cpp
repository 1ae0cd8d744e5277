// Places objects beside roads: lamps, signs, furniture, shelters.

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
using models::TrafficSign;

// The part of a road along which objects may be placed (m along the road).
struct PlantedRoad {
  const Road& road;
  double from, to;
};

std::vector<PlantedRoad> plantedRoads(const Layout& l) {
  std::vector<PlantedRoad> found;
  for (const Road& road : l.roads()) {
    if (road.minor) continue;
    found.push_back(road.main ? PlantedRoad{road, l.mainFrom, l.mainTo} : PlantedRoad{road, 10, road.length() - 3});
  }
  return found;
}

// Tries to place `per100m` objects per 100 m of each road that is not minor. For each object, calls `place` with random
// positions until it returns true, since the position is free, at most kTries times.
template <class Place>
void along(const Layout& l, Kind kind, double per100m, const Place& place) {
  std::uint32_t number = 0;
  for (const PlantedRoad& s : plantedRoads(l)) {
    Draw draw(l.seed, kind, s.road.number);
    const int count = static_cast<int>(per100m * std::max(0.0, s.to - s.from) / 100 + draw.next());
    for (int k = 0; k < count; ++k) {
      for (int attempt = 0; attempt < Placer::kTries; ++attempt) {
        const double at = draw.in(s.from, s.to);
        if (place(draw, s.road, at, draw.chance(0.5) ? 1 : -1, number + 1)) {
          ++number;
          break;
        }
      }
    }
  }
}

// Returns the spot `out` metres beyond the road's edge; nullopt if it is closer to another road, or within 0.3 m of a
// parking lot, a square or water.
std::optional<Spot> beyondEdge(const Layout& l, const Road& road, double distance, int side, double out) {
  const Spot spot = besideRoad(road, distance, side * (road.section.half + out));
  if (l.besideAt(spot.at).edge <= out - 0.25 || l.areas.outsideHard(spot.at) <= 0.3) return std::nullopt;
  return spot;
}

void placeLamps(Placer& placer, const std::vector<Model>& lamps) {
  const Layout& l = placer.layout;
  constexpr double kPost = 0.12;  // m; only the post needs ground: vehicles pass under the arm
  constexpr double kFree = kPost + Placer::kGap;
  for (const PlantedRoad& s : plantedRoads(l)) {
    Draw draw(l.seed, Kind::RoadLamps, s.road.number);
    const double spacing = l.character.country ? draw.in(60, 120) : draw.in(16, 30);
    const int side = draw.chance(0.5) ? 1 : -1;
    const Model& lamp = draw.itemOf(lamps);
    int number = 0;
    for (const double at : models::steps(s.from + draw.in(3, spacing), s.to, spacing)) {
      std::optional<Spot> spot = beyondEdge(l, s.road, at, side, s.road.section.curb + 0.45);
      if (!spot) continue;
      spot->yaw += -side * kPi / 2;  // the lamp's arm reaches over the road
      if (!placer.isFree({spot->at, kFree, kFree, spot->yaw})) continue;
      placer.occupancy.add({spot->at, kPost, kPost, spot->yaw});
      placer.put(lamp, *spot, fmt::format("lamp {}.{}", s.road.number + 1, ++number));
    }
  }
}

// Places signs along roads, which face the vehicles on their side, and signs where side roads end. `signs`: models in
// the order of TrafficSign.
void placeSigns(Placer& placer, const std::vector<Model>& signs) {
  const Layout& l = placer.layout;
  const auto modelOf = [&](TrafficSign sign) { return signs[static_cast<std::size_t>(sign)]; };
  constexpr std::array kAlongRoads{TrafficSign::SpeedLimit, TrafficSign::Warning, TrafficSign::Priority,
                                   TrafficSign::Parking};
  along(l, Kind::RoadSigns, l.character.country ? 1.5 : 5,
        [&](Draw& draw, const Road& road, double at, int side, std::uint32_t number) {
          std::optional<Spot> spot = beyondEdge(l, road, at, side, road.section.curb + draw.in(0.35, 0.7));
          if (!spot) return false;
          // Vehicles at the right of the road's line drive in the line's direction.
          spot->yaw += (side < 0 ? kPi : 0) + draw.in(-0.15, 0.15);
          return placer.tryPut(modelOf(draw.itemOf(kAlongRoads)), *spot, fmt::format("sign {}", number));
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

// Places bus shelters on wide pavements; their open side faces the road.
void placeShelters(Placer& placer) {
  constexpr double kRoom = 2.4;  // m, least width of verge and sidewalk
  const Layout& l = placer.layout;
  const Model shelter = models::makeShelter(placer.builder, l.seed);
  along(l, Kind::Shelters, 0.5, [&](Draw&, const Road& road, double at, int side, std::uint32_t number) {
    if (road.section.verge + road.section.sidewalk < kRoom) return false;
    std::optional<Spot> spot = beyondEdge(l, road, at, side, road.section.outer() - 0.9);
    if (!spot) return false;
    spot->yaw += side > 0 ? 0 : kPi;
    return placer.tryPut(shelter, *spot, fmt::format("shelter {}", number));
  });
}

void placeFurniture(Placer& placer, const std::vector<Model>& furnishings) {
  const Layout& l = placer.layout;
  along(l, Kind::RoadFurniture, l.character.clutter,
        [&](Draw& draw, const Road& road, double at, int side, std::uint32_t number) {
          const bool nearCurb = draw.chance(0.5);
          const double out =
              nearCurb ? road.section.curb + draw.in(0.3, 0.6) : road.section.outer() + draw.in(-0.5, 1.5);
          std::optional<Spot> spot = beyondEdge(l, road, at, side, out);
          if (!spot) return false;
          spot->yaw += (side > 0 ? 0 : kPi) + draw.in(-0.3, 0.3);
          const Model& m = draw.itemOf(furnishings);
          return placer.tryPut(m, *spot, fmt::format("furniture {}", number));
        });
}

constexpr double kRailPanel = 2;  // m, length of a panel

// Places a row of panels from `from` to `to` (m along the main road), `lateral` metres to the left of its line. Panels
// face to the left of the line if `facesLeft` is true. `up`: factor on their height.
void placeRow(Placer& placer, const Model& panel, double from, double to, double lateral, bool facesLeft, double up,
              const std::string& name) {
  const Road& road = placer.layout.mainRoad();
  int number = 0;
  for (const double at : models::steps(from, to, kRailPanel)) {
    const Spot spot = besideRoad(road, at + kRailPanel / 2, lateral);
    const Point2 first = besideRoad(road, at, lateral).at;
    const Point2 last = besideRoad(road, at + kRailPanel, lateral).at;
    Affine place = models::at(placer.layout.onGround(spot.at, -0.03), spot.yaw + (facesLeft ? kPi : 0));
    place.linear = place.linear * Mat3::scale({distance(first, last) / kRailPanel, 1, up});
    placer.builder.place(panel.mesh, placer.worldFromTown * place, fmt::format("{} {}", name, ++number));
    placer.occupancy.add({spot.at, kRailPanel / 2, 0.2, spot.yaw});
  }
}

}  // namespace

std::optional<TrafficSign> signAtMouth(const Layout& l, const Road& road) {
  Draw draw(l.seed, Kind::MouthSign, road.number);
  const TrafficSign sign = draw.chance(0.3) ? TrafficSign::Stop : TrafficSign::GiveWay;
  if (!road.joins || road.minor || !road.against || draw.chance(0.3)) return std::nullopt;
  return sign;
}

// Builds the models of lamps, signs and furniture, then places them in this order, with shelters before the furniture.
void placeFixtures(Placer& placer) {
  const std::uint64_t seed = placer.layout.seed;
  const auto lamps = models::makeForms(2, [&](int f) { return models::makeLamp(placer.builder, seed, f); });
  const auto signs = models::makeForms(
      models::kSigns, [&](int f) { return models::makeSign(placer.builder, seed, static_cast<TrafficSign>(f), f); });
  const auto furnishings = models::makeForms(static_cast<int>(Furnishing::Count), [&](int f) {
    return models::makeFurnishing(placer.builder, seed, static_cast<Furnishing>(f));
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
  Draw draw(l.seed, models::Kind::Rails);
  const auto panel = [&](Fencing what) { return models::makeFencePanel(placer.builder, l.seed, what); };
  const Model rail = panel(Fencing::GuardRail);
  const double length = road.length();
  if (draw.chance(0.5)) {
    placeRow(placer, panel(Fencing::Barrier), 2, length - 2, 0, false, 1, "median barrier");
  } else {
    placeRow(placer, rail, 2, length - 2, 0.15, true, 1, "median rail to the left");
    placeRow(placer, rail, 2, length - 2, -0.15, false, 1, "median rail to the right");
  }
  for (const double side : {-1.0, 1.0}) {
    const bool left = side > 0;
    const double edge = road.section.half + 0.6;
    const double begin = draw.in(2, 60);
    const double end = length - draw.in(2, 60);
    placeRow(placer, rail, begin, end, side * edge, !left, 1, left ? "left rail" : "right rail");
    if (!draw.chance(0.4)) continue;
    const double from = draw.in(10, length / 2);
    const double to = from + draw.in(60, length / 2 - 12);
    const double beyond = draw.in(2.5, 5);
    const double up = draw.in(1.6, 2.4);
    placeRow(placer, panel(Fencing::Boards), from, to, side * (edge + beyond), !left, up,
             left ? "left noise barrier" : "right noise barrier");
  }
}

}  // namespace scanmill::town
