// Vehicles, parked and on the lanes, and people.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "scene/town/placer.h"

namespace scanmill::town {
namespace {

using parts::CarForm;
using parts::Kind;

constexpr double kBay = 6;       // m along the curb
constexpr double kMiddle = 0.4;  // m from the middle of a road that vehicles on the other side keep

class Fleet {
 public:
  explicit Fleet(Placer& placer) : placer_(placer), made_(kCars, false), cars_(kCars) {}

  const Model& anyCar(Draw& draw) {
    const auto index = static_cast<std::size_t>(draw.below(kCars));
    if (!made_[index]) {
      // Hatchbacks and saloons are the most common: two of each.
      const auto form = static_cast<CarForm>(static_cast<int>(index) % parts::kCarForms);
      cars_[index] = parts::makeCar(placer_.builder, placer_.layout.seed(), form, static_cast<int>(index));
      made_[index] = true;
    }
    return cars_[index];
  }

 private:
  static constexpr int kCars = 2 * parts::kCarForms;
  Placer& placer_;
  std::vector<bool> made_;
  std::vector<Model> cars_;
};

void placeParked(Placer& placer, Fleet& fleet) {
  const Layout& l = placer.layout;
  const Character& c = l.character();
  int number = 0;
  for (std::uint32_t r = 0; r < l.roads().roads().size(); ++r) {
    const Road& road = l.roads().roads()[r];
    const CrossSection& s = road.section;
    const double first = road.main ? l.mainFrom() : 14;
    const double last = road.main ? l.mainTo() : road.length() - 4;
    for (const int side : {-1, 1}) {
      if (road.main && side < 0 && s.parking < 1.5) continue;  // the sensor's own lane stays free
      std::uint32_t bay = 0;
      for (double at = first; at + kBay < last; at += kBay) {
        Draw draw(l.seed(), Kind::Car, 10000 + 1000 * (2 * r + (side > 0 ? 1u : 0u)) + bay++);
        if (!draw.chance(s.parking > 1.5 ? c.parked : 0.15 * c.parked)) continue;
        const Model& car = fleet.anyCar(draw);
        const double half = (car.bounds.high.y - car.bounds.low.y) / 2;
        const double inwards = s.parking > 1.5 ? s.parking / 2 : half + 0.15;
        Spot spot = besideRoad(road, at + kBay / 2 + draw.in(-0.4, 0.4), side * (s.half - inwards));
        const Beside b = l.roads().at(spot.at.x, spot.at.y);
        if (std::abs(b.edge + inwards) > 0.3) continue;  // at a crossing
        // Driveways stay free.
        if (l.outsidePatches(besideRoad(road, at + kBay / 2, side * (s.half + s.outer() + 0.4)).at) < 2.2) continue;
        spot.yaw += (side > 0 ? kPi : 0) + (draw.chance(0.08) ? kPi : 0) + draw.in(-0.02, 0.02);
        if (placer.tryPark(car, spot, fmt::format("car {}", number + 1))) ++number;
      }
    }
  }
  std::uint32_t index = 0;
  for (const Patch& patch : l.patches()) {
    Draw draw(l.seed(), Kind::Car, 500000 + index++);
    if (patch.kind != GroundKind::Driveway || !draw.chance(c.parked > 0 ? std::min(0.6, 0.1 + c.parked) : 0)) continue;
    const Model& car = fleet.anyCar(draw);
    const double yaw = patch.place.yaw + kPi / 2;  // x towards the house
    const double in = patch.place.halfY - 3 - draw.in(0, 1);
    const Spot spot{{patch.place.center.x + std::cos(yaw) * in, patch.place.center.y + std::sin(yaw) * in},
                    yaw + (draw.chance(0.6) ? 0 : kPi) + draw.in(-0.03, 0.03),
                    1,
                    0};
    const Vec3d size = car.bounds.high - car.bounds.low;
    if (size.y > 2 * patch.place.halfX + 0.2) continue;
    placer.park(car, spot, fmt::format("car {}", ++number));
  }
}

// Which lane: 1 with the line, on its right; -1 against it, on its left. Drivers keep to the right.
Spot onLane(const Road& road, double at, int lane, double out, const Model& m) {
  const double least = (m.bounds.high.y - m.bounds.low.y) / 2 + kMiddle;
  const double center = std::max((road.section.half - road.section.parking) / 2 + out, least);
  Spot spot = besideRoad(road, at, -lane * center);
  if (lane < 0) spot.yaw += kPi;
  return spot;
}

struct Heavy {
  std::array<Model, 2> trucks;
  Model bus;
};

// A lorry that delivers and a bus that waits, in side roads, or where there are none on the main road's other side;
// trailers and tractors beside the road.
void placeStanding(Placer& placer, const Heavy& heavy) {
  const Layout& l = placer.layout;
  if (l.parameters().vehicles <= 0) return;
  Draw draw(l.seed(), Kind::Traffic, 3000);
  const std::vector<Road>& roads = l.roads().roads();
  const auto tryAt = [&](const Model& m, const Road& road, double at, double lateral, const std::string& name) {
    Spot spot = besideRoad(road, at, lateral);
    if (lateral > 0) spot.yaw += kPi;
    const Beside b = l.roads().at(spot.at.x, spot.at.y);
    // Not at a crossing, nor on a road that is not meant.
    if (!b.known || std::abs(b.edge - (std::abs(lateral) - road.section.half)) > 0.3) return false;
    return placer.tryPark(m, spot, name);
  };
  const auto onRoad = [&](const Model& m, const std::string& name) {
    const double wide = (m.bounds.high.y - m.bounds.low.y) / 2;
    for (int attempt = 0; attempt < 2 * Placer::kTries; ++attempt) {
      const int sides = static_cast<int>(roads.size()) - 1;
      const Road& road = roads[sides > 0 ? static_cast<std::size_t>(1 + draw.below(sides)) : 0];
      const double lateral = std::max(road.section.half - wide - 0.2, wide + kMiddle);
      const bool left = road.main || draw.chance(0.5);
      const double at = road.main ? draw.in(l.mainFrom() + 10, l.mainTo() - 10) : draw.in(12, 28);
      if (tryAt(m, road, at, left ? lateral : -lateral, name)) return;
    }
  };
  onRoad(heavy.bus, "waiting bus");
  onRoad(heavy.trucks[static_cast<std::size_t>(draw.below(2))], "delivering truck");
  const bool rural = l.character().district == District::Rural;
  const int others = 1 + draw.below(2);
  for (int k = 0; k < others; ++k) {
    const parts::WorkVehicle what = rural && draw.chance(0.6) ? parts::WorkVehicle::Tractor
                                    : draw.chance(0.7)        ? parts::WorkVehicle::Trailer
                                                              : parts::WorkVehicle::Caravan;
    const Model m = parts::makeWorkVehicle(placer.builder, l.seed(), what, k);
    for (int attempt = 0; attempt < 4 * Placer::kTries; ++attempt) {
      const Road& road = roads.front();
      const double beyond = road.section.half + road.section.outer() + draw.in(2, 8);
      const double at = draw.in(l.mainFrom() + 10, l.mainTo() - 10);
      if (tryAt(m, road, at, draw.chance(0.5) ? beyond : -beyond, fmt::format("other vehicle {}", k + 1))) break;
    }
  }
}

void placeMoving(Placer& placer, Fleet& fleet, const Heavy& heavy) {
  const Layout& l = placer.layout;
  const Character& c = l.character();
  int number = 0;
  for (std::uint32_t r = 0; r < l.roads().roads().size(); ++r) {
    const Road& road = l.roads().roads()[r];
    Draw draw(l.seed(), Kind::Traffic, 1000 + r);
    const double length = road.main ? l.mainTo() - l.mainFrom() : road.length() - 20;
    const int count = static_cast<int>(c.traffic * (road.main ? 1 : 0.4) * length / 100 + draw.next());
    for (int k = 0; k < count; ++k) {
      const double pick = draw.next();
      const Model& m = pick < 0.08 && road.main  ? heavy.bus
                       : pick < 0.2 && road.main ? heavy.trucks[static_cast<std::size_t>(draw.below(2))]
                                                 : fleet.anyCar(draw);
      // The sensor's own lane is that with the main road's line.
      const int lane = road.main ? -1 : draw.chance(0.5) ? 1 : -1;
      for (int attempt = 0; attempt < 8; ++attempt) {
        const double from = road.main ? l.mainFrom() : 14;
        Spot spot = onLane(road, from + draw.in(0, length), lane, draw.in(-0.2, 0.2), m);
        const Beside b = l.roads().at(spot.at.x, spot.at.y);
        if (b.road != r || b.edge < -road.section.half - 1) continue;
        spot.yaw += draw.in(-0.02, 0.02);
        if (!placer.tryPark(m, spot, fmt::format("traffic {}", number + 1))) continue;
        ++number;
        break;
      }
    }
  }
}

// A place on a pavement or a verge, or beside the road where there is neither.
bool besidePeople(const Placer& placer, Draw& draw, Spot& spot) {
  const Layout& l = placer.layout;
  const auto r =
      static_cast<std::size_t>(draw.chance(0.7) ? 0 : draw.below(static_cast<int>(l.roads().roads().size())));
  const Road& road = l.roads().roads()[r];
  const CrossSection& s = road.section;
  const double at = road.main ? draw.in(l.mainFrom(), l.mainTo()) : draw.in(10, road.length());
  const double out =
      s.sidewalk > 0 ? s.curb + s.verge + draw.in(0.3, std::max(0.4, s.sidewalk - 0.3)) : draw.in(0.4, 1);
  spot = besideRoad(road, at, (draw.chance(0.5) ? 1 : -1) * (s.half + out));
  spot.yaw += (draw.chance(0.5) ? 0 : kPi) + draw.in(-0.3, 0.3);
  const Beside b = l.roads().at(spot.at.x, spot.at.y);
  return b.edge > 0.2;
}

}  // namespace

void placeVehicles(Placer& placer) {
  Fleet fleet(placer);
  const std::uint64_t seed = placer.layout.seed();
  const Heavy heavy{{parts::makeTruck(placer.builder, seed, 0), parts::makeTruck(placer.builder, seed, 1)},
                    parts::makeBus(placer.builder, seed)};
  placeStanding(placer, heavy);
  placeParked(placer, fleet);
  placeMoving(placer, fleet, heavy);
}

void placePeople(Placer& placer) {
  const Layout& l = placer.layout;
  const double length = l.mainTo() - l.mainFrom();
  Draw counts(l.seed(), Kind::Person, 999);
  // One of each at least, unless nobody is wanted.
  const auto count = [&](double share) {
    const int drawn = static_cast<int>(share * l.character().people * length / 100 + counts.next());
    return l.parameters().people > 0 ? std::max(1, drawn) : 0;
  };
  const int walkers = count(1);
  const int parked = count(0.5);
  const int cyclists = count(0.25);
  const int motorcycles = count(0.25);
  const auto search = [&](const Model& m, Draw& draw, const std::string& name, double lean) {
    Spot spot;
    for (int attempt = 0; attempt < Placer::kTries; ++attempt) {
      if (!besidePeople(placer, draw, spot)) continue;
      spot.lean = lean;
      if (placer.tryPut(m, spot, name)) return;
    }
  };
  const auto forms = parts::makeForms(std::min(walkers, 12), [&](int f) {
    return parts::makePedestrian(placer.builder, l.seed() + static_cast<std::uint64_t>(f / 8), f % 8);
  });
  for (int i = 0; i < walkers; ++i) {
    Draw draw(l.seed(), Kind::Person, static_cast<std::uint32_t>(1000 + i));
    search(forms[static_cast<std::size_t>(i) % forms.size()], draw, fmt::format("pedestrian {}", i + 1), 0);
  }
  const auto bicycles =
      parts::makeForms(std::min(parked, 4), [&](int f) { return parts::makeBicycle(placer.builder, l.seed(), f); });
  for (int i = 0; i < parked; ++i) {
    Draw draw(l.seed(), Kind::Bicycle, static_cast<std::uint32_t>(1000 + i));
    search(bicycles[static_cast<std::size_t>(i) % bicycles.size()], draw, fmt::format("bicycle {}", i + 1),
           radians(draw.in(-9, -5)));
  }
  const auto motorcycleForms = parts::makeForms(
      std::min(motorcycles, 2), [&](int f) { return parts::makeMotorcycle(placer.builder, l.seed(), f); });
  for (int i = 0; i < motorcycles; ++i) {
    Draw draw(l.seed(), Kind::Motorcycle, static_cast<std::uint32_t>(1000 + i));
    search(motorcycleForms[static_cast<std::size_t>(i) % motorcycleForms.size()], draw,
           fmt::format("motorcycle {}", i + 1), radians(8));
  }
  const Road& main = l.roads().roads().front();
  for (int i = 0; i < cyclists; ++i) {
    Draw draw(l.seed(), Kind::Cyclist, static_cast<std::uint32_t>(1000 + i));
    parts::BicycleFit fit;
    const Model bicycle = parts::makeBicycle(placer.builder, l.seed(), 100 + i % 3, &fit);
    const Model rider = parts::makeRider(placer.builder, l.seed(), i % 3, fit);
    for (int attempt = 0; attempt < Placer::kTries; ++attempt) {
      const double lanes = main.section.half - main.section.parking;
      Spot spot = besideRoad(main, draw.in(l.mainFrom(), l.mainTo()), lanes - 0.6 + draw.in(-0.2, 0.1));
      spot.yaw += kPi + draw.in(-0.06, 0.06);
      if (!placer.occupancy.isFree(Placer::footprint(rider, spot, Placer::kGap))) continue;
      if (!placer.tryPut(bicycle, spot, fmt::format("cyclist's bicycle {}", i + 1))) continue;
      placer.put(rider, spot, fmt::format("cyclist {}", i + 1));
      break;
    }
  }
}

}  // namespace scanmill::town
