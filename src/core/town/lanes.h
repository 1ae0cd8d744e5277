#pragma once

// Ways (routes of vehicles) along the lanes of a town's roads.

#include <cstdint>
#include <optional>
#include <vector>

#include "town/layout.h"

namespace scanmill::town {

struct Way {
  struct Stretch {
    std::uint32_t road;
    double from, to;  // m along the road; vehicles drive from `from` to `to`
  };
  std::vector<Stretch> stretches;
  double before = 0, after = 0;  // m before the first and after the last stretch, hidden below ground
};

struct LaidOut {
  std::vector<Vec3d> points;  // in the town's frame, on the ground or hidden below it
  struct Place {
    std::uint32_t road;
    double along;
  };
  std::vector<Place> places;  // places[i]: the place of a road that points[first + i] is beside
  std::size_t first = 0;
};

// Returns the points of a way. Vehicles keep to the right: `out` m further from the road's centre line than the middle
// of their lane, and at least `least` m from the centre line. On one-way roads they drive `out` m to the right of the
// centre line.
LaidOut layOut(const Layout& l, const Way& way, double out, double least);

// Returns the distance along a side road at which its lanes begin (m).
double mouthOf(const Layout& l);
double stopAtMouth(const Layout& l);                    // returns where vehicles that come out of a side road stop
double endOf(const Layout& l, std::uint32_t sideRoad);  // returns where the lanes of a side road end
// Returns the distance (m) along the main road between a side road's joint and the start of the turn into it.
double cornerOf(const Layout& l, std::uint32_t sideRoad);

// The side roads on the right that the sensor's vehicle comes out of (`from`) and turns into (`into`). No other vehicle
// drives on these side roads.
struct Tour {
  std::optional<std::uint32_t> from, into;
  bool has(std::uint32_t road) const { return from == road || into == road; }
};
Tour tourOf(const Layout& l);

}  // namespace scanmill::town
