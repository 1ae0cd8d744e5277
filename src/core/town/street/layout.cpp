#include "town/street/layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace scanmill::street {

int Parameters::count(double density) const {
  return static_cast<int>(std::lround(density * length / 100));
}

Parameters readParameters(Fields& fields) {
  Parameters p;
  p.length = fields.number("length", {60, 5000}, p.length);
  p.roadWidth = fields.number("road_width", {5, 20}, p.roadWidth);
  p.parkingWidth = fields.number("parking_width", {0, 4}, p.parkingWidth);
  p.curbHeight = fields.number("curb_height", {0.04, 0.3}, p.curbHeight);
  p.sidewalkWidth = fields.number("sidewalk_width", {1.5, 8}, p.sidewalkWidth);
  p.frontGarden = fields.number("front_garden", {2, 20}, p.frontGarden);
  p.terrain = fields.number("terrain", {50, 500}, p.terrain);
  p.beyond = fields.number("beyond", {20, 500}, p.beyond);
  p.crossStreet = fields.boolean("cross_street", p.crossStreet);
  p.buildings = fields.number("buildings", {0, 1}, p.buildings);
  p.boundaries = fields.number("boundaries", {0, 1}, p.boundaries);
  const Range density{0, 200};
  p.trees = fields.number("trees", density, p.trees);
  p.bushes = fields.number("bushes", density, p.bushes);
  p.cars = fields.number("cars", density, p.cars);
  p.traffic = fields.number("traffic", density, p.traffic);
  p.trucks = fields.number("trucks", density, p.trucks);
  p.buses = fields.number("buses", density, p.buses);
  p.motorcycles = fields.number("motorcycles", density, p.motorcycles);
  p.bicycles = fields.number("bicycles", density, p.bicycles);
  p.cyclists = fields.number("cyclists", density, p.cyclists);
  p.pedestrians = fields.number("pedestrians", density, p.pedestrians);
  p.signs = fields.number("signs", density, p.signs);
  p.lamps = fields.number("lamps", density, p.lamps);
  p.furniture = fields.number("furniture", density, p.furniture);
  p.shelters = fields.number("shelters", density, p.shelters);
  if (p.parkingWidth > 0 && p.parkingWidth < 2) {
    throw InputError(
        fields.where(),
        fmt::format("street: parking_width is {} m: give 0 for no parking, or at least 2 m", p.parkingWidth));
  }
  const double built = p.roadWidth / 2 + p.parkingWidth + Layout::kCurb + p.sidewalkWidth + p.frontGarden;
  if (p.terrain < built + 25) {
    throw InputError(fields.where(), fmt::format("street: terrain is {} m, but the houses start {} m from the centre "
                                                 "line: give at least {} m, or narrower roads and gardens",
                                                 p.terrain, built, built + 25));
  }
  return p;
}

namespace {

// m, depth of the flat part of a plot, from the front line; it exceeds the deepest house's setback plus depth.
constexpr double kPlotDepth = 18;
constexpr double kUndulation = 0.5;  // m, largest amplitude of a wave of the terrain

}  // namespace

Layout::Layout(const Parameters& parameters, std::uint64_t streetSeed)
    : p(parameters),
      seed(streetSeed),
      roadEdge(p.roadWidth / 2),
      parkingEdge(roadEdge + p.parkingWidth),
      walkInner(parkingEdge + kCurb),
      walkOuter(walkInner + p.sidewalkWidth),
      front(walkOuter + p.frontGarden),
      halfLength(p.length / 2),
      halfX(halfLength + p.beyond),
      halfY(p.terrain),
      cross(p.crossStreet) {
  Draw draw(seed, Kind::Plot);
  crossEdge = 3.0;
  crossWalk = crossEdge + kCurb + p.sidewalkWidth;
  cornerRadius = walkOuter - roadEdge;
  crossSidewalkEnd = std::min(front + kPlotDepth + kCrossSidewalkEnd, halfY - 5);
  const double reach = std::min(0.3 * p.length, halfLength - crossEdge - cornerRadius - 12);
  crossX = cross ? std::round(draw.in(-reach, reach) * 10) / 10 : 0;

  Draw terrain(seed, Kind::Terrain);
  for (std::size_t i = 0; i < waves_.size(); i += 4) {
    const double angle = terrain.in(0, 2 * kPi);
    const double wavelength = terrain.in(25, 70);
    waves_[i] = 2 * kPi / wavelength * std::cos(angle);
    waves_[i + 1] = 2 * kPi / wavelength * std::sin(angle);
    waves_[i + 2] = terrain.in(0, 2 * kPi);
    waves_[i + 3] = terrain.in(0.5, 1.0) * kUndulation;
  }

  const double parkingGap = crossEdge + cornerRadius + 6;
  const double plotGap = crossWalk + 1.5;
  if (cross) {
    if (p.parkingWidth > 0) parking = {{-halfLength + 4, crossX - parkingGap}, {crossX + parkingGap, halfLength - 4}};
    for (const int side : {-1, 1}) {
      addLots(side, {-halfLength + 2, crossX - plotGap});
      addLots(side, {crossX + plotGap, halfLength - 2});
    }
    addCrossHouses();
  } else {
    if (p.parkingWidth > 0) parking = {{-halfLength + 4, halfLength - 4}};
    for (const int side : {-1, 1}) addLots(side, {-halfLength + 2, halfLength - 2});
  }
}

void Layout::addLots(int side, Span x) {
  constexpr double kNarrowest = 9;  // m, least width of a lot
  double start = x.low;
  while (x.high - start > kNarrowest) {
    Lot lot;
    lot.side = side;
    lot.number = static_cast<std::uint32_t>(lots.size());
    Draw draw(seed, Kind::Lot, lot.number);
    double end = start + draw.in(12, 21);
    if (x.high - end < kNarrowest) end = std::min(x.high, start + 24);
    lot.x = {start, end};
    const double width = end - start;
    const bool hasDriveway = width > 13.5 && draw.chance(0.45);
    const bool drivewayFirst = draw.chance(0.5);
    const double drivewayGap = hasDriveway ? draw.in(3.4, 4.4) : draw.in(0.6, 2.6);
    const double otherGap = draw.in(0.6, 1.6);
    const double low = start + (drivewayFirst ? drivewayGap : otherGap);
    const double high = end - (drivewayFirst ? otherGap : drivewayGap);

    const double depth = draw.in(8.5, 12.5);
    const int floors = draw.of(std::array{1, 2, 2, 2, 3, 3, 4});
    House house = drawHouse(draw, lot.number, high - low, depth, floors);
    house.shop = house.floors >= 3 && draw.chance(0.5);
    const double setback = front + draw.in(0, kPathDepth);
    house.place = side > 0 ? at({low, setback, p.curbHeight}) : at({high, -setback, p.curbHeight}, kPi);
    const bool built = draw.next() < p.buildings;
    if (draw.next() < p.boundaries) {
      lot.fencing = draw.of(std::array{Fencing::Pickets, Fencing::Bars, Fencing::Brick, Fencing::Hedge});
    }
    if (built) {
      const double door = side > 0 ? low + house.doorX() : high - house.doorX();
      lot.walkway = {door - 0.7, door + 0.7};
      houses.push_back(house);
      if (hasDriveway) {
        lot.driveway = drivewayFirst ? Span{start + 0.35, low - 0.25} : Span{high + 0.25, end - 0.35};
        const auto beside = [&](const Span& s) { return lot.driveway.low > s.low && lot.driveway.high < s.high; };
        lot.lowered = p.parkingWidth == 0 || std::any_of(parking.begin(), parking.end(), beside);
      }
    }
    lots.push_back(lot);
    start = end;
  }
}

// Adds a few houses along the cross street, behind the gardens of the houses at the main street.
void Layout::addCrossHouses() {
  for (const double sideX : {-1.0, 1.0}) {
    for (const double sideY : {-1.0, 1.0}) {
      House house;
      house.number = 1000000 + static_cast<std::uint32_t>(sideX > 0) * 2 + static_cast<std::uint32_t>(sideY > 0);
      Draw draw(seed, Kind::Lot, house.number);
      house.width = draw.in(9, 12);
      house.depth = draw.in(8, 10);
      house.floors = 1 + draw.below(2);
      house.columns = static_cast<int>(house.width / 2.6);
      house.doorColumn = draw.below(house.columns);
      house.roof = draw.chance(0.5) ? Roof::Gable : Roof::Hip;
      const double x = crossX + sideX * (crossWalk + draw.in(3, 6));
      const double y = front + kPlotDepth + draw.in(1, 4);
      const bool built = draw.next() < p.buildings;
      if (!built || y + house.width > halfY - 2) continue;
      // At the +x side of the cross street the front faces -x: a rotation by -90 degrees turns the house's -y axis to
      // -x.
      const double along = sideY > 0 ? y : -y - house.width;
      house.place =
          sideX > 0 ? at({x, along + house.width, p.curbHeight}, -kPi / 2) : at({x, along, p.curbHeight}, kPi / 2);
      houses.push_back(house);
    }
  }
}

bool Layout::inCorner(double x, double y) const {
  const double u = std::abs(x - crossX) - crossEdge;
  const double v = std::abs(y) - roadEdge;
  return cross && u > 0 && u < cornerRadius && v > 0 && v < cornerRadius;
}

bool Layout::besideParking(double x, double margin) const {
  return std::any_of(parking.begin(), parking.end(),
                     [&](const Span& s) { return x > s.low - margin && x < s.high + margin; });
}

bool Layout::onStrip(Span Lot::*strip, double x, int side, double margin) const {
  return std::any_of(lots.begin(), lots.end(), [&](const Lot& lot) {
    const Span& s = lot.*strip;
    return lot.side == side && s.high > s.low && x > s.low - margin && x < s.high + margin;
  });
}

Ground Layout::kindAt(double x, double y) const {
  const double ay = std::abs(y);
  const double ax = std::abs(x - crossX);
  if (ay < roadEdge || (cross && ax < crossEdge)) return Ground::Road;
  if (ay < parkingEdge && besideParking(x, 0)) return Ground::Parking;

  const int side = y > 0 ? 1 : -1;
  const auto lot = std::find_if(lots.begin(), lots.end(), [&](const Lot& l) { return l.side == side && l.x.holds(x); });
  const bool driveway = lot != lots.end() && lot->driveway.holds(x);
  if (ay < (besideParking(x, kCurb) ? walkInner : roadEdge + kCurb) || (cross && ax < crossEdge + kCurb)) {
    return driveway && lot->lowered ? Ground::LoweredCurb : Ground::Curb;
  }
  if (std::abs(x) < halfLength && ay < walkOuter) {
    return driveway && lot->lowered && ay < walkInner + kRamp ? Ground::Ramp : Ground::Sidewalk;
  }
  if (cross && ax < crossWalk && ay < crossSidewalkEnd) return Ground::Sidewalk;
  if (driveway && ay < front + kDrivewayDepth) return Ground::Driveway;
  if (lot != lots.end() && lot->walkway.holds(x) && ay < front + kPathDepth) return Ground::Path;
  return Ground::Terrain;
}

double Layout::heightAt(Ground kind, double x, double y) const {
  switch (kind) {
    case Ground::Road:
    case Ground::Parking:
      return 0;
    case Ground::LoweredCurb:
      return kLoweredCurb;
    case Ground::Ramp:
      return lerp(kLoweredCurb, p.curbHeight, std::clamp((std::abs(y) - walkInner) / kRamp, 0.0, 1.0));
    case Ground::Curb:
    case Ground::Sidewalk:
      return p.curbHeight;
    case Ground::Driveway:
    case Ground::Path:
    case Ground::Terrain:
      break;
  }
  return terrainHeight(x, y);
}

double Layout::terrainHeight(double x, double y) const {
  const double ay = std::abs(y);
  const double behindPlots = smooth((ay - front - kPlotDepth) / 15);
  const double outOfTown = smooth((std::abs(x) - halfLength - 3) / 25) * smooth((ay - walkInner) / 12);
  const double besideCross = cross ? smooth((std::abs(x - crossX) - crossWalk - 17) / 14) : 1;
  double wave = 0;
  for (std::size_t i = 0; i < waves_.size(); i += 4) {
    wave += waves_[i + 3] * std::sin(waves_[i] * x + waves_[i + 1] * y + waves_[i + 2]);
  }
  return p.curbHeight + std::max(behindPlots, outOfTown) * besideCross * wave;
}

}  // namespace scanmill::street
