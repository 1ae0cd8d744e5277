#pragma once

// Paths of vehicles along the lanes of a town's roads.

#include <cstdint>
#include <functional>
#include <vector>

#include "town/layout.h"

namespace scanmill::town {

constexpr int kRoadCyclistForms = 3;  // number of forms of cyclists on roads; the next forms are for sidewalks
constexpr double kMiddle = 0.4;       // m, least distance between a vehicle and the centre line

// A part of a road in the direction of driving: from `from` to `to` (m along the road's line).
struct RoadInterval {
  std::uint32_t road;
  double from, to;
};

// The path of vehicles along the lanes of successive roads.
struct LanePath {
  std::vector<RoadInterval> intervals;
  double hiddenBefore = 0, hiddenAfter = 0;  // m of path below ground, before the first and after the last interval
};

struct LanePoints {
  std::vector<Vec3d> points;  // in the town's frame, on the ground; hidden points are below
  struct RoadPosition {
    std::uint32_t road;
    double along;  // m
  };
  std::vector<RoadPosition> positions;  // [i]: road position of points[firstOnRoad + i]
  std::size_t firstOnRoad = 0;
};

// Returns the points of a path. `lateral` returns the distance (m) of the path from a road's centre line, to the right
// in the direction of driving.
LanePoints lanePoints(const Layout& l, const LanePath& path, const std::function<double(const Road&)>& lateral);

// States where the ego vehicle drives on two-way roads; follows from the town's seed. In plain towns it keeps to the
// middle of the rightmost lane, and on one-way roads to the centre line.
struct EgoLine {
  int lane = 0;              // on roads with several lanes in a direction: number of the lane, 0 is the rightmost
  double towardsMiddle = 0;  // m; on roads with one: distance from the middle of the lane towards the centre line
};
EgoLine egoLine(const Layout& l);

// Returns the points of the ego vehicle's path; see EgoLine.
LanePoints egoLanePoints(const Layout& l, const LanePath& path);

// These functions return distances (m) along a side road: the start and the end of its lanes, and its stop line.
inline double laneStart(const Layout& l) {
  return l.mainRoad().section.half + 7;
}
inline double laneEnd(const Road& sideRoad) {
  return sideRoad.length() - 6;
}
inline double stopLineOfSideRoad(const Layout& l) {
  return laneStart(l) - 4;
}
// Returns the distance along the main road (m) between a junction and the start of the turn into `sideRoad`.
inline double turnStart(const Road& sideRoad) {
  return sideRoad.section.half + 6;
}

// The side roads at the right of the main road on which the ego vehicle's route with turns starts and ends.
struct EgoRoads {
  const Road* from = nullptr;  // null: there is no such road
  const Road* into = nullptr;
  bool has(const Road& road) const { return from == &road || into == &road; }
};
EgoRoads egoRoads(const Layout& l);

}  // namespace scanmill::town
