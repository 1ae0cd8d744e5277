// Places parked vehicles, traffic, cyclists and bicycles.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "town/street/placer.h"

namespace scanmill::street {
namespace {

// The models of the street's cars; all are built when the first is needed.
class Fleet {
 public:
  explicit Fleet(Placer& placer) : placer_(placer) {}

  const Model& anyCar(Draw& draw) {
    if (cars_.empty()) {
      // Hatchbacks and saloons are the most common cars: there are two models of each.
      cars_ = makeForms(kCarForms + 2, [&](int k) {
        return makeCar(placer_.builder, placer_.layout.seed, static_cast<CarForm>(k % kCarForms), k);
      });
    }
    return draw.of(cars_);
  }

 private:
  Placer& placer_;
  std::vector<Model> cars_;
};

struct Bay {
  double x;
  int side;
  double key;  // random number; bays are filled in the order of these numbers
};

std::vector<Bay> bays(const Placer& placer) {
  const Layout& l = placer.layout;
  constexpr double kBay = 6.0;  // m, length of a parking bay
  std::vector<Bay> found;
  for (const Span& s : l.parking) {
    for (const int side : {-1, 1}) {
      for (double x = s.low + 0.3; x + kBay < s.high; x += kBay) {
        const double middle = x + kBay / 2;
        if (l.onStrip(&Lot::driveway, middle, side, kBay / 2 - 0.6)) continue;
        Draw draw(l.seed, Kind::Car, static_cast<std::uint32_t>(100000 + found.size()));
        found.push_back({middle, side, draw.next()});
      }
    }
  }
  std::sort(found.begin(), found.end(), [](const Bay& a, const Bay& b) { return a.key < b.key; });
  return found;
}

void placeParked(Placer& placer, Fleet& fleet) {
  const Layout& l = placer.layout;
  const int cars = l.p.count(l.p.cars);
  const int motorcycles = l.p.count(l.p.motorcycles);
  const std::vector<Bay> free = bays(placer);
  // Up to three motorcycles share a bay, at an angle to the road. Motorcycles fill bays from the end of the list, cars
  // from its beginning.
  const auto motorcycleForms =
      makeForms(motorcycles > 0 ? 2 : 0, [&](int f) { return makeMotorcycle(placer.builder, l.seed, f); });
  int standing = 0;
  std::size_t end = free.size();
  for (int place = 0; standing < motorcycles && end > 0; ++place) {
    Draw draw(l.seed, Kind::Motorcycle, static_cast<std::uint32_t>(1000 + place));
    const Bay& b = free[end - 1];
    const double y = b.side * (l.roadEdge + l.p.parkingWidth / 2);
    const Spot s{b.x + (place % 3 - 1) * 1.5 + draw.in(-0.15, 0.15), y, b.side * -radians(40) + draw.in(-0.1, 0.1), 1,
                 radians(8)};
    const Model& m = draw.of(motorcycleForms);
    if (placer.tryPut(m, s, fmt::format("motorcycle {}", standing + 1))) ++standing;
    if (place % 3 == 2 || standing == motorcycles) --end;
  }
  // Some cars are placed in driveways, the others in bays.
  int parked = 0;
  for (const Lot& lot : l.lots) {
    if (lot.driveway.high - lot.driveway.low < 2.6) continue;
    Draw draw(l.seed, Kind::Car, 50000 + lot.number);
    if (parked >= cars || !draw.chance(0.4)) continue;
    const Model& m = fleet.anyCar(draw);
    const double y = l.front + draw.in(2.0, 4.0);
    const Spot s{(lot.driveway.low + lot.driveway.high) / 2 + draw.in(-0.1, 0.1), lot.side * y,
                 lot.side * kPi / 2 * (draw.chance(0.7) ? 1 : -1) + draw.in(-0.02, 0.02), 1, 0};
    if (placer.tryPut(m, s, fmt::format("car {}", parked + 1))) ++parked;
  }
  for (std::size_t i = 0; parked < cars && i < end; ++i) {
    Draw draw(l.seed, Kind::Car, static_cast<std::uint32_t>(1000 + i));
    const Bay& b = free[i];
    const Model& m = fleet.anyCar(draw);
    const double half = (m.bounds.high.y - m.bounds.low.y) / 2;
    const double room = l.p.parkingWidth / 2 - half;  // m between a car in the bay's middle and each edge of the bay
    const bool against = draw.chance(0.08);
    const double yaw = (b.side > 0) == against ? 0 : kPi;  // on the left side traffic drives to -x
    const double error = draw.in(-0.02, 0.02);
    const double swing = std::abs(error) * (m.bounds.high.x - m.bounds.low.x) / 2;
    if (room < swing) continue;
    const double y = b.side * (l.roadEdge + l.p.parkingWidth / 2) + draw.in(-1, 1) * (room - swing);
    const Spot s{b.x + draw.in(-0.3, 0.3), y, yaw + error, 1, 0};
    if (placer.tryPut(m, s, fmt::format("car {}", parked + 1))) ++parked;
  }
}

// Places oncoming vehicles in the left lane, and vehicles that wait at the lights in the cross street. The right lane
// is free for the sensor's vehicle.
void placeTraffic(Placer& placer, Fleet& fleet) {
  const Layout& l = placer.layout;
  const int buses = l.p.count(l.p.buses);
  const int trucks = l.p.count(l.p.trucks);
  const int cars = l.p.count(l.p.traffic);
  const auto trucksMade = makeForms(std::min(trucks, 2), [&](int f) { return makeTruck(placer.builder, l.seed, f); });
  Model bus;
  if (buses > 0) bus = makeBus(placer.builder, l.seed);
  for (int i = 0; i < buses + trucks + cars; ++i) {
    Draw draw(l.seed, Kind::Traffic,
              static_cast<std::uint32_t>(i < buses            ? 20000 + i
                                         : i < buses + trucks ? 10000 + i - buses
                                                              : i - buses - trucks));
    const Model* m = &bus;
    std::string name = fmt::format("traffic bus {}", i + 1);
    int car = -1;
    if (i >= buses + trucks) {
      car = i - buses - trucks;
      m = &fleet.anyCar(draw);
      name = fmt::format("traffic car {}", car + 1);
    } else if (i >= buses) {
      m = &trucksMade[static_cast<std::size_t>(i - buses) % trucksMade.size()];
      name = fmt::format("traffic truck {}", i - buses + 1);
    }
    if (l.cross && car >= 0 && car % 3 == 1) {
      const double side = car % 2 == 1 ? -1 : 1;
      const int row = car / 6;  // place in the queue on this side of the intersection; 0: at the lights
      const double nose = l.walkOuter + 2.0 + m->bounds.high.x + draw.in(0, 0.6) + row * 7.0;
      const Spot s{l.crossX - side * l.crossEdge / 2 + draw.in(-0.15, 0.15), side * nose, -side * kPi / 2, 1, 0};
      placer.tryPut(*m, s, name);
      continue;
    }
    placer.search(*m, name, [&] {
      double x = placer.alongStreet(draw, 8);
      // The vehicle must not be in the intersection.
      const double reach = l.crossEdge + l.cornerRadius + (m->bounds.high.x - m->bounds.low.x) / 2;
      if (l.cross && std::abs(x - l.crossX) < reach) x = l.crossX + (x > l.crossX ? reach : -reach);
      return Spot{x, l.roadEdge / 2 + draw.in(-0.15, 0.1), kPi + draw.in(-0.01, 0.01), 1, 0};
    });
  }
}

void placeCyclists(Placer& placer) {
  const Layout& l = placer.layout;
  const int count = l.p.count(l.p.cyclists);
  const auto pairs = makeForms(std::min(count, 3), [&](int f) {
    RiderFit fit;
    const Model bicycle = makeBicycle(placer.builder, l.seed, 100 + f, &fit);
    return std::pair(bicycle, makeRider(placer.builder, l.seed, f, fit));
  });
  for (int i = 0; i < count; ++i) {
    Draw draw(l.seed, Kind::Cyclist, static_cast<std::uint32_t>(i));
    const auto& [bicycle, rider] = pairs[static_cast<std::size_t>(i) % pairs.size()];
    for (int k = 0; k < Placer::kTries; ++k) {
      const Spot s{placer.alongStreet(draw, 6), l.roadEdge - 0.6 + draw.in(-0.2, 0.1), kPi + draw.in(-0.06, 0.06), 1,
                   0};
      if (!placer.occupancy.isFree(footprint(rider, s, Placer::kGap))) continue;
      if (!placer.tryPut(bicycle, s, fmt::format("cyclist's bicycle {}", i + 1))) continue;
      placer.put(rider, s, fmt::format("cyclist {}", i + 1));
      break;
    }
  }
}

}  // namespace

void placeVehicles(Placer& placer) {
  Fleet fleet(placer);
  placeParked(placer, fleet);
  placeTraffic(placer, fleet);
  placeCyclists(placer);
}

void placeBicycles(Placer& placer) {
  const Layout& l = placer.layout;
  const int count = l.p.count(l.p.bicycles);
  const auto forms = makeForms(std::min(count, 4), [&](int f) { return makeBicycle(placer.builder, l.seed, f); });
  for (int i = 0; i < count; ++i) {
    Draw draw(l.seed, Kind::Bicycle, static_cast<std::uint32_t>(1000 + i));
    placer.search(draw.of(forms), fmt::format("bicycle {}", i + 1), [&] {
      Spot s = placer.onSidewalk(draw, -0.45, 0.8);
      s.yaw = (draw.chance(0.5) ? 0 : kPi) + draw.in(-0.15, 0.15);
      s.lean = radians(draw.in(-9, -5));  // the bicycle leans on its stand
      return s;
    });
  }
}

}  // namespace scanmill::street
