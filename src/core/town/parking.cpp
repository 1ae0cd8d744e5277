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

// Returns the distance of a parked car's middle beyond the carriageway's edge (m; negative: on the carriageway). Cars
// park in the middle of a parking lane; else on the sidewalk, if lane and sidewalk stay passable; else at the curb, or,
// on roads of the ego vehicle, nowhere (nullopt). `half`: half of the car's width (m).
std::optional<double> parkedBeyondEdge(const Road& road, double half, bool egoDrives) {
  constexpr double kBesideLane = 1.6;  // m between a lane's middle and parked cars, enough for lorries
  constexpr double kWalk = 0.7;        // m, width of the sidewalk that stays free
  constexpr double kFromCurb = 0.15;   // m between a car on the carriageway and the curb
  const CrossSection& s = road.section;
  if (s.parking > kParkingLane) return -s.parking / 2;
  const double onSidewalk = std::max(0.1, road.laneMiddle() + kBesideLane + half - s.half);
  if (s.verge == 0 && onSidewalk + half < s.fenced() - kWalk && !road.oneWay()) return onSidewalk;
  return egoDrives ? std::nullopt : std::optional(-half - kFromCurb);
}

// Places cars in the bays and at the curb of one side of a road. `egoDrives`: true on roads that the ego vehicle uses.
// `firstBay`: number of the first bay; each bay has its own random stream. Returns the last bay's number plus 1.
std::uint32_t placeCarsAtSide(Placer& placer, const Road& road, int side, bool egoDrives, std::uint32_t firstBay) {
  constexpr double kDrivewayClear = 2.2;  // m between a bay's middle and driveways
  const Layout& l = placer.layout;
  const CrossSection& s = road.section;
  const bool hasLane = s.parking > kParkingLane;
  const double first = road.main ? l.mainFrom : 14;
  const double last = road.main ? l.mainTo : road.length() - 4;
  // A random choice says whether parking at this side is usual.
  Draw sidewalk(l.seed, Kind::SidewalkParking, 2 * road.number + (side > 0 ? 1u : 0u));
  const bool usual = sidewalk.chance(hasLane ? 0.7 : egoDrives ? 0.25 : 0.95);
  // Roads with less traffic have more parked cars.
  const double parked = std::min(0.95, (!egoDrives ? 4 : hasLane ? 0.8 : 0.5) * l.character.parked);
  std::uint32_t bay = firstBay;
  for (double along = first; along + kBay < last; along += kBay) {
    Draw draw(l.seed, Kind::ParkedCar, bay++);
    if (!draw.chance(usual ? parked : 0.15 * parked)) continue;
    const Model& car = anyCar(placer, draw);
    const std::optional<double> out = parkedBeyondEdge(road, car.width() / 2, egoDrives);
    if (!out || (*out > 0 && !usual)) continue;
    const bool narrowsLane = *out <= 0 && !hasLane;
    if (narrowsLane && usual && !draw.chance(0.15)) continue;
    Spot spot = besideRoad(road, along + kBay / 2 + draw.in(-0.4, 0.4), side * (s.half + *out));
    const bool atCrossing = std::abs(l.besideAt(spot.at).edge - *out) > 0.3;
    const Spot behindSidewalk = besideRoad(road, along + kBay / 2, side * (s.half + s.outer() + 0.4));
    if (atCrossing || l.outsidePatches(behindSidewalk.at) < kDrivewayClear) continue;
    if (draw.chance(0.08)) spot.yaw += kPi;
    spot.yaw += (side > 0 ? kPi : 0) + draw.in(-0.02, 0.02);
    placer.tryNumbered("car", [&](const std::string& name) { return placer.tryPark(car, spot, name); });
  }
  return bay;
}

// Places cars side by side on a wide forecourt, in as many rows as fit between the house and the road, or one car on a
// driveway, two on a deep one. The patch's y axis points to the house.
void placeCarsOn(Placer& placer, const Patch& patch, Draw& draw) {
  constexpr double kBeside = 2.7;          // m between the middles of neighbours
  constexpr double kFromSide = 1;          // m, least distance between a car's middle and the forecourt's end
  constexpr double kMiddleFromHouse = 3;   // m, least distance between a car's middle and the house
  constexpr double kBeyondDriveway = 0.2;  // m by which a car may be wider than the ground
  constexpr double kRow = 6;               // m between the middles of two rows
  constexpr double kAisle = 5;             // m of free ground after every second row of a wide forecourt
  constexpr double kLeastRow = 3;   // m, least distance between a car's middle and the forecourt's end at the road
  constexpr double kMirrors = 0.3;  // m, least distance between the bodies of cars on neighbouring forecourts
  const TurnedRectangle& ground = patch.rectangle;
  const double parked = placer.layout.character.parked;
  const bool wide = ground.halfX > kBeside;
  const std::vector<double> places =
      wide ? models::steps(-ground.halfX + kBeside / 2, ground.halfX - kFromSide, kBeside) : std::vector{0.0};
  const double last = 2 * ground.halfY - kLeastRow - 1;  // m from the house, largest distance of a car's middle
  double fromHouse = kMiddleFromHouse;
  for (int row = 0; row == 0 || (fromHouse < last && (wide || row < 2)); ++row) {
    for (const double u : places) {
      if (!draw.chance(row > 0 ? 0.9 : wide ? 0.85 + 0.1 * parked : 0.85 + 0.15 * parked)) continue;
      const Model& car = anyCar(placer, draw);
      if (car.width() > 2 * ground.halfX + kBeyondDriveway) continue;
      const double v = ground.halfY - fromHouse - draw.in(0, 1);
      const double turn = draw.chance(0.6) ? 0 : kPi;  // rad; most cars have their front at the house
      const Spot spot{.at = ground.at(u, v), .yaw = ground.yaw + kPi / 2 + turn + draw.in(-0.03, 0.03)};
      const bool isOnSidewalk = placer.layout.besideAt(spot.at).isOnRoadOrSidewalk(car.length() / 2);
      if (row > 0 && isOnSidewalk) continue;
      placer.tryNumbered("car", [&](const std::string& name) {
        const bool free = placer.occupancy.isFree(footprint(car, spot, kMirrors));
        if (free) placer.park(car, spot, name);
        return free;
      });
    }
    fromHouse += kRow + (row % 2 == 1 ? kAisle : 0);
  }
}

// Places cars at the sides of roads, except minor roads and one-way roads without a parking lane; then cars on
// driveways and forecourts.
void placeCars(Placer& placer) {
  const Layout& l = placer.layout;
  const EgoRoads ego = egoRoads(l);
  std::uint32_t bay = 0;
  for (const Road& road : l.roads()) {
    if (road.minor || (road.oneWay() && road.section.parking < kParkingLane)) continue;
    for (const int side : {-1, 1}) bay = placeCarsAtSide(placer, road, side, road.main || ego.has(road), bay);
  }
  std::uint32_t index = 0;
  for (const Patch& patch : l.patches) {
    Draw draw(l.seed, Kind::ForecourtCars, index++);
    if (patch.parks && l.character.parked > 0) placeCarsOn(placer, patch, draw);
  }
}

// Width and depth of bays on parking lots, and width of the aisle between two rows of bays (m).
constexpr double kBayWidth = 2.6, kBayDepth = 5, kAisle = 6.2;

// True if a point is on a parking lot, at least kFromEdge from the lot's edge and from roads through the lot.
bool isOnLot(const Placer& placer, const Point2& p) {
  constexpr double kFromEdge = 1.2;  // m
  const Areas& areas = placer.layout.areas;
  const Beside b = placer.layout.besideAt(p);
  return placer.isOnGround(p) && areas.outsideHard(p) < -kFromEdge && areas.landAt(p) == Land::Lot &&
         (!b.nearRoad || b.edge > b.section.outer() + kFromEdge);
}

// Paints the lines of a row of bays and parks cars in some bays. `about`: rectangle around the lot, x axis along
// the row; `low`: lower end of the bays on the y axis (m); `facing`: 1 if most cars face +y, -1 if most face -y;
// `occupied`: fraction of bays with a car. Returns the number of lines.
int placeRowOfBays(Placer& placer, models::Shape& s, models::SurfaceIndex paint, const Footprint& about, double low,
                   int facing, double occupied, Draw& draw) {
  constexpr double kHalfLotLine = 0.06;  // m, half of a line's width
  constexpr double kIntoBay = 0.8;       // m from a bay's ends to the points that must be on the lot
  const Layout& l = placer.layout;
  int lines = 0;
  for (const double u : models::steps(-about.halfX + 0.8, about.halfX - kBayWidth - 0.4, kBayWidth)) {
    const auto inBay = [&](double v) { return about.at(u + kBayWidth / 2, low + v); };
    Spot spot{.at = inBay(kBayDepth / 2), .yaw = about.yaw + facing * kPi / 2};
    const bool hasCar = draw.chance(occupied);
    if (!isOnLot(placer, spot.at) || !isOnLot(placer, inBay(kIntoBay)) ||
        !isOnLot(placer, inBay(kBayDepth - kIntoBay))) {
      continue;
    }
    for (const double line : {u, u + kBayWidth}) {
      const auto corner = [&](double side, double v) {
        return l.onGround(about.at(line + side * kHalfLotLine, v), 0.01);
      };
      s.quad(paint, corner(-1, low), corner(1, low), corner(1, low + kBayDepth), corner(-1, low + kBayDepth));
      ++lines;
    }
    if (!hasCar) continue;
    if (!draw.chance(0.7)) spot.yaw += kPi;
    spot.yaw += draw.in(-0.04, 0.04);
    const Model& car = anyCar(placer, draw);
    placer.tryNumbered("car on a lot", [&](const std::string& name) { return placer.tryPark(car, spot, name); });
  }
  return lines;
}

// Paints rows of bays on parking lots, with an aisle between two rows, and parks cars in some of the bays.
void placeLots(Placer& placer) {
  const Layout& l = placer.layout;
  models::Shape s(placer.builder, "lots' markings");
  const models::SurfaceIndex paint = s.surface("road_marking", "road_paint");
  std::uint32_t lotNumber = 0;
  int lines = 0;
  for (const MapArea& area : l.areas.list()) {
    if (area.land != Land::Lot) continue;
    Draw draw(l.seed, Kind::Lot, ++lotNumber);
    const double fullness = draw.next();
    const double occupied = std::min(0.95, l.parameters.vehicles * (0.3 + 0.65 * fullness));
    Footprint about = rectangleAbout(area.outline);
    if (about.halfX < about.halfY) {
      std::swap(about.halfX, about.halfY);
      about.yaw += kPi / 2;
    }
    bool secondRow = false;  // true: the second row of an aisle
    for (double low = -about.halfY + 0.4; low + kBayDepth < about.halfY - 0.2; secondRow = !secondRow) {
      lines += placeRowOfBays(placer, s, paint, about, low, secondRow ? -1 : 1, occupied, draw);
      low += kBayDepth + (secondRow ? 0 : kAisle);
    }
  }
  if (lines > 0) placer.putShape(s);
}

// Parks a vehicle `lateral` m to the left of a road's line. Returns false if the spot is at a crossing or not free.
bool tryStand(Placer& placer, const Model& vehicle, const Road& road, double along, double lateral,
              const std::string& name) {
  Spot spot = besideRoad(road, along, lateral);
  if (lateral > 0) spot.yaw += kPi;
  const Beside b = placer.layout.besideAt(spot.at);
  if (!b.nearRoad || std::abs(b.edge - (std::abs(lateral) - road.section.half)) > 0.3) return false;
  return placer.tryPark(vehicle, spot, name);
}

// Tries to place a lorry or bus at the edge of a random side road that the ego vehicle's route does not use; in a town
// without side roads, at the left edge of the main road.
void placeAtEdge(Placer& placer, Draw& draw, const Model& vehicle, const std::string& name) {
  const Layout& l = placer.layout;
  const double half = vehicle.width() / 2;
  for (int attempt = 0; attempt < 2 * Placer::kTries; ++attempt) {
    const int sideRoads = static_cast<int>(l.roads().size()) - 1;
    const Road& road = l.roads()[sideRoads > 0 ? static_cast<std::size_t>(1 + draw.below(sideRoads)) : 0];
    if (egoRoads(l).has(road) || road.minor || road.oneWay()) continue;
    const double lateral = std::max(road.section.half - half - 0.2, half + kMiddle);
    const bool left = road.main || draw.chance(0.5);
    const double along = road.main ? draw.in(l.mainFrom + 10, l.mainTo - 10) : draw.in(12, 28);
    if (tryStand(placer, vehicle, road, along, left ? lateral : -lateral, name)) return;
  }
}

// Places buses and a lorry at the edges of roads, and trailers, caravans and tractors beside the main road.
void placeStanding(Placer& placer) {
  const Layout& l = placer.layout;
  if (l.character.motorway) return;
  Draw draw(l.seed, Kind::StandingVehicles);
  const double share = l.parameters.vehicles;
  const auto isWanted = [&] { return share >= 1 || draw.chance(share); };
  const int buses = l.character.lights > 0.4 ? 2 : 1;  // towns with traffic lights have a second bus
  for (int k = 0; k < buses; ++k) {
    if (isWanted()) placeAtEdge(placer, draw, busOf(placer), k == 0 ? "waiting bus" : "waiting bus 2");
  }
  if (isWanted()) placeAtEdge(placer, draw, anyTruck(placer, draw), "delivering truck");
  const int workVehicles = 1 + draw.below(3);
  for (int k = 0; k < workVehicles; ++k) {
    if (!isWanted()) continue;
    const models::WorkVehicle kind = l.character.country && draw.chance(0.6) ? models::WorkVehicle::Tractor
                                     : draw.chance(0.7)                      ? models::WorkVehicle::Trailer
                                                                             : models::WorkVehicle::Caravan;
    const Model m = models::makeWorkVehicle(placer.builder, l.seed, kind, k);
    for (int attempt = 0; attempt < 4 * Placer::kTries; ++attempt) {
      const Road& road = l.mainRoad();
      const double lateral = road.section.half + road.section.outer() + draw.in(2, 8);
      const double along = draw.in(l.mainFrom + 10, l.mainTo - 10);
      const int side = draw.chance(0.5) ? 1 : -1;
      if (tryStand(placer, m, road, along, side * lateral, fmt::format("other vehicle {}", k + 1))) break;
    }
  }
}

}  // namespace

const Model& anyCar(Placer& placer, Draw& draw) {
  const int number = draw.below(2 * models::kCarForms);  // two models of each form
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
