// Places stationary vehicles: cars in bays, at curbs and in driveways; delivery vehicles, trailers and tractors.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "town/lanes.h"
#include "town/placer.h"

namespace scanmill::town {
namespace {

using models::Kind;

constexpr double kBay = 6;            // m, length of a parking bay along the curb
constexpr double kParkingLane = 1.5;  // m, least width of a lane in which cars park

// Returns how far beyond the edge of the carriageway (m, negative: on it) the middle of a parked car stands: in the
// middle of a parking lane, or half on the sidewalk if both the lane and a part of the sidewalk stay free, or else, on
// roads that the ego vehicle does not use, at the curb. nullopt: there is no place. `half`: half of the car's
// width.
std::optional<double> parkedAt(const Road& road, double half, bool keepClear) {
  constexpr double kBesideLane = 1.6;  // m between the middle of a lane and parked cars: lorries pass
  constexpr double kWalk = 0.7;        // m, width of the sidewalk that stays free
  const CrossSection& s = road.section;
  if (s.parking > kParkingLane) return -s.parking / 2;
  const double out = std::max(0.1, road.laneMiddle() + kBesideLane + half - s.half);
  if (s.verge == 0 && out + half < s.fenced() - kWalk && !road.oneWay()) return out;
  return keepClear ? std::nullopt : std::optional(-half - 0.15);
}

// Places cars in the bays and at the curb of one side of a road. `bay`: number of the first place; each place has a
// random stream of its own. `number`: cars so far. Both are advanced.
void placeCarsAtSide(Placer& placer, const Road& road, int side, bool egoDrives, std::uint32_t& bay, int& number) {
  const Layout& l = placer.layout;
  const CrossSection& s = road.section;
  const bool hasLane = s.parking > kParkingLane;
  const double first = road.main ? l.mainFrom : 14;
  const double last = road.main ? l.mainTo : road.length() - 4;
  // Along a road without parking lanes drivers park half on the sidewalk on one side, on both or on none.
  const bool custom =
      hasLane ||
      Draw(l.seed, Kind::SidewalkParking, 2 * road.number + (side > 0 ? 1u : 0u)).chance(egoDrives ? 0.35 : 0.75);
  // More cars stand in roads where fewer pass.
  const double parked = std::min(0.95, (!egoDrives ? 3 : hasLane ? 0.8 : 0.5) * l.character.parked);
  for (double at = first; at + kBay < last; at += kBay) {
    Draw draw(l.seed, Kind::ParkedCar, bay++);
    if (!draw.chance(custom ? parked : 0.15 * parked)) continue;
    const Model& car = anyCar(placer, draw);
    const double halfWidth = (car.bounds.high.y - car.bounds.low.y) / 2;
    const std::optional<double> out = parkedAt(road, halfWidth, egoDrives);
    if (!out || (*out > 0 && !custom)) continue;
    if (*out <= 0 && !hasLane && custom && !draw.chance(0.15)) continue;  // they narrow the lane
    Spot spot = besideRoad(road, at + kBay / 2 + draw.in(-0.4, 0.4), side * (s.half + *out));
    const Beside b = l.besideAt(spot.at);
    if (std::abs(b.edge - *out) > 0.3) continue;  // the bay is at a crossing
    // Driveways are kept clear.
    constexpr double kClear = 2.2;  // m
    if (l.outsidePatches(besideRoad(road, at + kBay / 2, side * (s.half + s.outer() + 0.4)).at) < kClear) continue;
    if (draw.chance(0.08)) spot.yaw += kPi;
    spot.yaw += (side > 0 ? kPi : 0) + draw.in(-0.02, 0.02);
    if (placer.tryPark(car, spot, fmt::format("car {}", number + 1))) ++number;
  }
}

// Places cars side by side on wide forecourts, with gaps; a driveway has room for one car. `number`: see
// placeCarsAtSide().
void placeCarsOn(Placer& placer, const Patch& patch, Draw& draw, int& number) {
  constexpr double kBeside = 2.7;  // m between the middles of neighbours
  const double parked = placer.layout.character.parked;
  const bool wide = patch.rectangle.halfX > kBeside;
  const double first = wide ? -patch.rectangle.halfX + kBeside / 2 : 0;
  for (const double u : models::steps(first, wide ? patch.rectangle.halfX - 1 : 1, kBeside)) {
    if (!draw.chance(wide ? 0.65 + 0.3 * parked : 0.85 + 0.15 * parked)) continue;
    const Model& car = anyCar(placer, draw);
    if (car.bounds.high.y - car.bounds.low.y > 2 * patch.rectangle.halfX + 0.2) continue;
    const double in = patch.rectangle.halfY - 3 - draw.in(0, 1);
    const double yaw = patch.rectangle.yaw + kPi / 2;  // direction from the road to the house
    const double turned = draw.chance(0.6) ? 0 : kPi;
    const Spot spot{patch.rectangle.at(u, in), yaw + turned + draw.in(-0.03, 0.03), 1, 0};
    if (!placer.occupancy.isFree(footprint(car, spot, Placer::kGap))) continue;
    placer.park(car, spot, fmt::format("car {}", ++number));
  }
}

void placeCars(Placer& placer) {
  const Layout& l = placer.layout;
  const EgoRoads ego = egoRoads(l);
  int number = 0;
  std::uint32_t bay = 0;
  for (const Road& road : l.roads()) {
    if (road.minor || (road.oneWay() && road.section.parking < kParkingLane)) continue;
    for (const int side : {-1, 1}) placeCarsAtSide(placer, road, side, road.main || ego.has(road), bay, number);
  }
  std::uint32_t index = 0;
  for (const Patch& patch : l.patches) {
    Draw draw(l.seed, Kind::ForecourtCars, index++);
    if (patch.parks && l.character.parked > 0) placeCarsOn(placer, patch, draw, number);
  }
}

constexpr double kBayWidth = 2.6, kBayDepth = 5,
                 kAisle = 6.2;  // m, of bays on parking lots and between two rows of them

// True if a point is on a parking lot, not at its edge, and not on a road through it.
bool isOnLot(const Placer& placer, const Point2& p) {
  constexpr double kFromEdge = 1.2;  // m
  const Areas& areas = placer.layout.areas;
  const Beside b = placer.layout.besideAt(p);
  return placer.isOnGround(p) && areas.outsideHard(p) < -kFromEdge && areas.landAt(p) == Land::Lot &&
         (!b.nearRoad || b.edge > b.section.outer() + kFromEdge);
}

// Paints the lines of a row of bays and parks cars in a part of them. `about`: the rectangle around the lot, with its x
// axis along the row; `low`: m along its y axis, where the row begins. `facing`: 1 or -1, along this axis. `taken`:
// fraction of the bays with a car. `number`: cars so far; it is advanced. Returns the number of lines.
int placeRowOfBays(Placer& placer, models::Shape& s, models::SurfaceIndex paint, const Footprint& about, double low,
                   int facing, double taken, Draw& draw, int& number) {
  constexpr double kHalfLotLine = 0.06;  // m, half of a line's width
  constexpr double kIntoBay = 0.8;       // m from a bay's ends to the points that must be on the lot
  const Layout& l = placer.layout;
  const auto paintLine = [&](double u) {
    const auto corner = [&](double side, double v) { return l.onGround(about.at(u + side * kHalfLotLine, v), 0.01); };
    s.quad(paint, corner(-1, low), corner(1, low), corner(1, low + kBayDepth), corner(-1, low + kBayDepth));
  };
  int lines = 0;
  for (const double u : models::steps(-about.halfX + 0.8, about.halfX - kBayWidth - 0.4, kBayWidth)) {
    const double middle = u + kBayWidth / 2;
    Spot spot{about.at(middle, low + kBayDepth / 2), about.yaw + facing * kPi / 2, 1, 0};
    const bool wanted = draw.chance(taken);
    if (!isOnLot(placer, spot.at) || !isOnLot(placer, about.at(middle, low + kIntoBay)) ||
        !isOnLot(placer, about.at(middle, low + kBayDepth - kIntoBay))) {
      continue;
    }
    paintLine(u);
    paintLine(u + kBayWidth);
    lines += 2;
    if (!wanted) continue;
    if (!draw.chance(0.7)) spot.yaw += kPi;
    spot.yaw += draw.in(-0.04, 0.04);
    if (placer.tryPark(anyCar(placer, draw), spot, fmt::format("car on a lot {}", number + 1))) ++number;
  }
  return lines;
}

// Places cars on parking lots: aisles with a row of bays at each side, and lines between the bays.
void placeLots(Placer& placer) {
  const Layout& l = placer.layout;
  models::Shape s(placer.builder, "lots' markings");
  const models::SurfaceIndex paint = s.surface("road_marking", "road_paint");
  std::uint32_t lot = 0;
  int lines = 0;
  int number = 0;
  for (const MapArea& area : l.areas.list()) {
    if (area.land != Land::Lot) continue;
    Draw draw(l.seed, Kind::Lot, ++lot);
    // Few lots are full.
    const double full = draw.next();
    const double taken = std::min(0.95, l.parameters.vehicles * (0.2 + 0.7 * full * full));
    Footprint about = rectangleAbout(area.outline);
    if (about.halfX < about.halfY) {
      std::swap(about.halfX, about.halfY);
      about.yaw += kPi / 2;
    }
    bool far = false;  // true for the second of the two rows at an aisle
    for (double low = -about.halfY + 0.4; low + kBayDepth < about.halfY - 0.2; far = !far) {
      lines += placeRowOfBays(placer, s, paint, about, low, far ? -1 : 1, taken, draw, number);
      low += kBayDepth + (far ? 0 : kAisle);
    }
  }
  if (lines > 0) placer.builder.place(s.finish().mesh, placer.worldFromTown, "lots' markings");
}

// Places a delivering lorry and a waiting bus in side roads or, if there are no side roads, on the far side of the main
// road. Also places trailers, caravans and tractors beside the main road.
void placeStanding(Placer& placer) {
  const Layout& l = placer.layout;
  if (l.character.motorway) return;
  Draw draw(l.seed, Kind::StandingVehicles);
  const double share = l.parameters.vehicles;
  const auto wanted = [&] { return share >= 1 || draw.chance(share); };
  const std::vector<Road>& roads = l.roads();
  const auto tryAt = [&](const Model& m, const Road& road, double at, double lateral, const std::string& name) {
    Spot spot = besideRoad(road, at, lateral);
    if (lateral > 0) spot.yaw += kPi;
    const Beside b = l.besideAt(spot.at);
    // The place must not be at a crossing or on another road.
    if (!b.nearRoad || std::abs(b.edge - (std::abs(lateral) - road.section.half)) > 0.3) return false;
    return placer.tryPark(m, spot, name);
  };
  const auto onRoad = [&](const Model& m, const std::string& name) {
    const double wide = (m.bounds.high.y - m.bounds.low.y) / 2;
    for (int attempt = 0; attempt < 2 * Placer::kTries; ++attempt) {
      const int sides = static_cast<int>(roads.size()) - 1;
      const Road& road = roads[sides > 0 ? static_cast<std::size_t>(1 + draw.below(sides)) : 0];
      if (egoRoads(l).has(road) || road.minor || road.oneWay()) continue;
      const double lateral = std::max(road.section.half - wide - 0.2, wide + kMiddle);
      const bool left = road.main || draw.chance(0.5);
      const double at = road.main ? draw.in(l.mainFrom + 10, l.mainTo - 10) : draw.in(12, 28);
      if (tryAt(m, road, at, left ? lateral : -lateral, name)) return;
    }
  };
  // Towns with traffic lights have a second bus.
  const int buses = l.character.lights > 0.4 ? 2 : 1;
  for (int k = 0; k < buses; ++k) {
    if (wanted()) onRoad(busOf(placer), k == 0 ? "waiting bus" : "waiting bus 2");
  }
  if (wanted()) onRoad(anyTruck(placer, draw), "delivering truck");
  const bool rural = l.character.country;
  const int others = 1 + draw.below(3);
  for (int k = 0; k < others; ++k) {
    if (!wanted()) continue;
    const models::WorkVehicle what = rural && draw.chance(0.6) ? models::WorkVehicle::Tractor
                                     : draw.chance(0.7)        ? models::WorkVehicle::Trailer
                                                               : models::WorkVehicle::Caravan;
    const Model m = models::makeWorkVehicle(placer.builder, l.seed, what, k);
    for (int attempt = 0; attempt < 4 * Placer::kTries; ++attempt) {
      const Road& road = roads.front();
      const double beyond = road.section.half + road.section.outer() + draw.in(2, 8);
      const double at = draw.in(l.mainFrom + 10, l.mainTo - 10);
      if (tryAt(m, road, at, draw.chance(0.5) ? beyond : -beyond, fmt::format("other vehicle {}", k + 1))) break;
    }
  }
}

}  // namespace

const Model& anyCar(Placer& placer, Draw& draw) {
  const int number = draw.below(2 * models::kCarForms);  // there are two cars of each form
  const auto form = static_cast<models::CarForm>(number % models::kCarForms);
  return placer.model(Kind::Car, number,
                      [&] { return models::makeCar(placer.builder, placer.layout.seed, form, number); });
}

const Model& anyTruck(Placer& placer, Draw& draw) {
  const int form = draw.below(2);
  return placer.model(Kind::Truck, form, [&] { return models::makeTruck(placer.builder, placer.layout.seed, form); });
}

const Model& busOf(Placer& placer) {
  return placer.model(Kind::Bus, 0, [&] { return models::makeBus(placer.builder, placer.layout.seed); });
}

void placeVehicles(Placer& placer) {
  placeStanding(placer);
  placeCars(placer);
  placeLots(placer);
}

}  // namespace scanmill::town
