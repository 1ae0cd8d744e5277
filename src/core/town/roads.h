#pragma once

// The roads of a town: centre lines with cross sections, and positions relative to them, in the town's frame (m).

#include <algorithm>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "models/occupancy.h"

namespace scanmill::town {

using models::Point2;

// The cross section of a road (m). On both sides, from the middle: carriageway, curb stone, verge (grass), sidewalk.
struct CrossSection {
  double half = 3.5;      // half of the width of the carriageway, with its parking lanes
  double parking = 0;     // width of the parking lane at each edge, part of `half`; 0: none
  double curb = 0.15;     // width of the curb stone; 0: no curb stone and no step
  double verge = 0;       // width of the grass between curb and sidewalk
  double sidewalk = 2.5;  // width of the sidewalk; 0: none
  double step = 0.12;     // height of the curb
  double apron = 0;       // width of the part of the plots that is paved like the sidewalk
  double shoulder = 0;    // width of the hard shoulder at each edge, part of `half`; 0: none
  double median = 0;      // half of the width of the central reservation, part of `half`; 0: none
  int lanes = 1;          // number of lanes in each direction

  double outer() const { return curb + verge + sidewalk; }               // width from the road's edge to the plots
  double paved() const { return outer() + (sidewalk > 0 ? apron : 0); }  // width from the road's edge to unpaved ground
  // Returns the distance (m) from the carriageway's edge to fences: at the plots' edge or behind an apron below 3 m.
  double fenced() const { return outer() + (apron < 3 ? apron : 0); }
  double laneWidth() const { return (half - parking - shoulder - median) / lanes; }
  bool operator==(const CrossSection&) const = default;
};

struct Road {
  std::uint32_t number = 0;    // index among the roads of the network
  std::vector<Point2> line{};  // centre line, in steps of about kRoadStep
  std::vector<double> at{};    // m along `line`, for each of its points
  CrossSection section{};
  bool main = false;
  bool minor = false;  // true: a service road or track, without lamps and without parked or waiting vehicles
  bool ring = false;   // true: a roundabout
  // Set for side roads: where the road starts (m along the main road), and whether it is at the main road's left.
  std::optional<double> joins{};
  bool joinsLeft = false;
  // `along` is true if vehicles may drive in the direction of the line, `against` if they may drive against it.
  bool along = true, against = true;

  double length() const { return at.back(); }
  bool oneWay() const { return !along || !against; }
  // Returns the distance (m) of the rightmost lane's middle from the centre line; 0 on one-way roads.
  double laneMiddle() const { return oneWay() ? 0 : section.median + (section.lanes - 0.5) * section.laneWidth(); }
  Point2 point(double distance) const;
  // Returns the direction of the line, a unit vector, `distance` metres along the line.
  Point2 heading(double distance) const;
};

constexpr double kRoadStep = 2;  // m between the points of a road's line

// Returns the spot `along` m along a road and `lateral` m to the left of its line, with the line's direction as yaw.
models::Spot besideRoad(const Road& road, double along, double lateral);

// The position of a point relative to the nearest road. If `nearRoad` is false, the other members are not set.
struct Beside {
  bool nearRoad = false;  // true: a road's centre line is within RoadNetwork::kReach
  double edge = 1e9;      // m beyond the carriageway's edge; negative on the road; corners at joints are rounded
  std::uint32_t road = 0;
  double along = 0;      // m along the road's centre line
  double lateral = 0;    // m to the left of the centre line
  CrossSection section;  // at a crossing, a mixture of the roads' cross sections

  // True if the point is on a road or its sidewalk, or less than `gap` metres beyond the sidewalk.
  bool isOnRoadOrSidewalk(double gap = 0) const { return nearRoad && edge < section.outer() + gap; }
};

class RoadNetwork {
 public:
  static constexpr double kReach = 48;  // m, largest distance from which at() finds a road's centre line

  void add(Road road);
  // Adds a point where roads meet. Corners between roads are rounded only near joints.
  void addJoint(const Point2& joint);
  const std::vector<Road>& roads() const { return roads_; }

  // Returns the position of a point relative to the nearest road.
  Beside at(const Point2& p) const;

 private:
  double roundingAt(const Point2& p) const;  // m, rounding of corners near joints: see at()

  // Successive segments of a road's line, and their bounding box.
  struct Run {
    std::uint32_t road;
    std::uint32_t first, last;  // indices of the first and the last point in the line
    Point2 low, high;

    // Returns a point's distances (m) from the bounding box: along x and along y.
    Point2 outside(double x, double y) const {
      return {std::max({0.0, low.x - x, x - high.x}), std::max({0.0, low.y - y, y - high.y})};
    }
  };
  struct RunOfCell {
    std::uint32_t run;
    float least;  // m, lower bound of the distance from the cell's points to the run; may be negative
  };
  // The point of a road that is nearest to a given point.
  struct NearestPoint {
    double squaredDistance;       // m^2
    std::uint32_t road, segment;  // indices of the road, and of a segment of its line
    double along;                 // m along the road's centre line
    bool left;                    // true: the given point is to the left of the line
    double beyondEnd;             // m by which the given point is beyond the start or end of the road
  };
  void enterLastRun();  // adds the last run of runs_ to the cells near it
  // Sets `nearest` to the nearest point of each road within kReach, in the order of the roads.
  void findNearest(double x, double y, std::vector<NearestPoint>& nearest) const;
  void findNearestOnRun(const Run& run, double x, double y, std::vector<NearestPoint>& nearest) const;

  static constexpr double kCell = 8;  // m, side of a grid cell

  std::vector<Road> roads_;
  std::vector<Run> runs_;
  // The runs within kReach of a cell, sorted by road, then by RunOfCell::least.
  std::unordered_map<std::uint64_t, std::vector<RunOfCell>> cells_;
  std::vector<Point2> joints_;
  models::CellIndex jointCells_{kCell};  // by cell, indices of the joints that round corners there
};

}  // namespace scanmill::town
