#pragma once

// Ways (routes of vehicles) along the lanes of a town's roads.

#include <cstdint>
#include <vector>

#include "town/layout.h"

namespace scanmill::town {

constexpr int kRoadCyclistForms = 3;  // number of forms of cyclists on roads; those on sidewalks have the next ones
constexpr double kMiddle = 0.4;       // m, least distance between a vehicle and the centre line

struct Way {
  struct Stretch {
    std::uint32_t road;
    double from, to;  // m along the road; vehicles drive from `from` to `to`
  };
  std::vector<Stretch> stretches;
  double before = 0, after = 0;  // m of hidden way below ground, before the first and after the last stretch
};

struct LaidOut {
  std::vector<Vec3d> points;  // in the town's frame, on the ground or hidden below it
  struct Place {
    std::uint32_t road;
    double along;
  };
  std::vector<Place> places;  // points[first + i] is beside places[i]
  std::size_t first = 0;
};

// Returns the points of a way. Vehicles keep to the right: they drive `out` metres farther from the road's centre line
// than the middle of their lane, and at least `least` metres from the centre line. On one-way roads they drive `out`
// metres to the right of the centre line.
LaidOut layOut(const Layout& l, const Way& way, double out, double least);

// Returns the distance along a side road (m) at which its lanes begin, which is the same for all side roads.
double mouthOf(const Layout& l);
double stopAtMouth(const Layout& l);  // returns where vehicles that leave a side road stop (m along it)
double endOf(const Road& sideRoad);   // m along the side road; its lanes end here
// Returns the distance along the main road (m) between a side road's junction and the start of the turn into it.
double cornerOf(const Road& sideRoad);

// The side roads from which the sensor's vehicle comes (`from`) and into which it turns (`into`), both at the right of
// the main road. No other vehicle drives on these side roads.
struct Tour {
  const Road* from = nullptr;  // null: there is no such road
  const Road* into = nullptr;
  bool has(const Road& road) const { return from == &road || into == &road; }
};
Tour tourOf(const Layout& l);

}  // namespace scanmill::town
