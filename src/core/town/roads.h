#pragma once

// The roads of a town: centre lines with their widths, and where a point lies beside them. In the town's frame, metres.

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "models/occupancy.h"

namespace scanmill::town {

using models::Point2;

// From the road's edge outwards on both sides: curb stone, verge (grass), sidewalk; then come the plots.
struct CrossSection {
  double half = 3.5;      // of the carriageway with its parking lanes
  double parking = 0;     // width of the parking lane within that, at the edge; 0: none
  double curb = 0.15;     // width of the curb stone; 0: none, and no step
  double verge = 0;       // width of the grass between curb and sidewalk
  double sidewalk = 2.5;  // width; 0: none
  double step = 0.12;     // height of the curb

  double outer() const { return curb + verge + sidewalk; }  // from the road's edge to the plots
};

struct Road {
  std::vector<Point2> line;  // the centre line, in steps of about kRoadStep
  std::vector<double> at;    // the distance along it of each point
  CrossSection section;
  bool main = false;
  bool minor = false;  // a service road or track: without lamps, and nobody parks or waits there
  bool ring = false;   // a roundabout
  // Of a side road of the main one: where along that it begins, and whether to the left of its line.
  std::optional<double> joins;
  bool joinsLeft = false;
  // Which ways vehicles may drive: along the line, against it.
  bool along = true, against = true;

  double length() const { return at.back(); }
  bool oneWay() const { return !along || !against; }
  // How far the middle of a lane lies from the road's (m); one-way roads are one lane.
  double laneMiddle() const { return oneWay() ? 0 : (section.half - section.parking) / 2; }
  Point2 point(double distance) const;
  // The direction of the line there (unit length).
  Point2 heading(double distance) const;
};

constexpr double kRoadStep = 2;  // m

// Where a point lies: beside the nearest road, or on it.
struct Beside {
  bool known = false;  // a road is nearer than RoadNetwork::kReach
  double edge = 1e9;   // m beyond the edge of the carriageway, negative on it; edges of crossing roads are rounded
  std::uint32_t road = 0;
  double along = 0;      // m along its centre line
  double lateral = 0;    // m to the left of it
  CrossSection section;  // at a crossing between those of the roads
};

class RoadNetwork {
 public:
  static constexpr double kReach = 48;  // m, from the centre line

  void add(Road road);
  // Where roads meet: corners are rounded about joints alone. Elsewhere roads lie side by side.
  void addJoint(const Point2& joint);
  const std::vector<Road>& roads() const { return roads_; }

  Beside at(double x, double y) const;

 private:
  double roundingAt(double x, double y) const;

  // Some segments of a road's line, one after the other, and the box around them.
  struct Run {
    std::uint32_t road;
    std::uint32_t first, last;  // points of the line
    Point2 low, high;
  };
  struct Near {
    double distance;
    std::uint32_t road;
    double along;
    bool left;
    double behind;  // m beyond the road's first or last point, along its line
  };
  // The nearest segment of each road in reach, in the order of the roads.
  void nearest(double x, double y, std::vector<Near>& found) const;

  std::vector<Road> roads_;
  std::unordered_map<std::uint64_t, std::vector<Run>> cells_;      // that they are in reach of
  std::unordered_map<std::uint64_t, std::vector<Point2>> joints_;  // by the cells that they reach
};

}  // namespace scanmill::town
