#pragma once

// Ways along the lanes of a town's roads.

#include <cstdint>
#include <optional>
#include <vector>

#include "town/layout.h"

namespace scanmill::town {

struct Way {
  struct Stretch {
    std::uint32_t road;
    double from, to;  // m along the road; it is driven from `from` to `to`
  };
  std::vector<Stretch> stretches;
  double before = 0, after = 0;  // m of way before it and behind it, out of sight below the ground
};

struct LaidOut {
  std::vector<Vec3d> points;  // on the ground, town's frame
  struct Place {
    std::uint32_t road;
    double along;
  };
  std::vector<Place> places;  // of points[first] and those behind it: which place of a road they are beside
  std::size_t first = 0;
};

// Drivers keep to the right: `out` m further from the road's middle than the middle of their lane, and at least `least`
// m from it. On one-way roads their lane is the whole road.
LaidOut layOut(const Layout& l, const Way& way, double out, double least);

// Where the lanes of side roads begin, as distances along them, and end; and how far before and behind a side road's
// joint the bends into it begin on the main road.
double mouthOf(const Layout& l);
double stopAtMouth(const Layout& l);  // where those who come out of one stop
double endOf(const Layout& l, std::uint32_t sideRoad);
double cornerOf(const Layout& l, std::uint32_t sideRoad);

// The side roads to the right that the sensor's vehicle may come out of and turn into. Nobody else is on them.
struct Tour {
  std::optional<std::uint32_t> from, into;
  bool has(std::uint32_t road) const { return from == road || into == road; }
};
Tour tourOf(const Layout& l);

}  // namespace scanmill::town
