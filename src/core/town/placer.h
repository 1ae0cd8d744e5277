#pragma once

// Places objects on the ground of a town where it is free.

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "town/layout.h"

namespace scanmill::town {

using models::Footprint;
using models::Model;

struct Spot {
  Point2 at;
  double yaw = 0;
  double scale = 1;
  double lean = 0;  // roll about x, rad
};

class Placer {
 public:
  static constexpr int kTries = 16;
  static constexpr double kGap = 0.15;  // least distance between objects, m

  Placer(SceneBuilder& builder, const Layout& layout, const Affine& worldFromTown);

  // Places a model upright, its origin on the ground or `sink` (m) below it, even if the place is taken.
  void put(const Model& m, const Spot& s, const std::string& name, double sink = 0);
  // Places the model if the place is free, otherwise returns false.
  bool tryPut(const Model& m, const Spot& s, const std::string& name, double sink = 0);
  // Does the same for a model on wheels, which tilts with the ground. Returns false also where noParking is taken.
  bool tryPark(const Model& m, const Spot& s, const std::string& name);
  // Places a model on wheels even if the place is taken.
  void park(const Model& m, const Spot& s, const std::string& name);

  static Footprint footprint(const Model& m, const Spot& s, double grow);

  SceneBuilder& builder;
  const Layout& layout;
  const Affine& worldFromTown;
  // True if a rectangle lies within the town's ground and on no driveway, path or placed object.
  bool isFree(const Footprint& f) const {
    constexpr double kEdge = 3;  // m
    const double reach = layout.half() - kEdge;
    return std::abs(f.center.x) < reach && std::abs(f.center.y) < reach && driveways.isFree(f) && occupancy.isFree(f);
  }

  models::Occupancy occupancy;  // rectangles that objects cover
  models::Occupancy driveways;  // driveways and paths, which stay clear
  models::Occupancy noParking;  // where nothing on wheels may be placed
  // The traffic lights of the main road for vehicles that drive against the road's line.
  struct Light {
    static constexpr double kPeriod = 44;  // s
    static constexpr double kRed = 16;     // s of the period
    double along;                          // where vehicles stop, m along the road
    double offset;                         // s, start of a period
    bool marked;                           // with a stop line on the road
  };
  std::vector<Light> lights;

 private:
  Vec3d onGround(const Point2& p, double sink) const;
};

// Returns a place beside a road, at a distance along its line and `lateral` metres to the left of it, with the yaw of
// the line.
Spot besideRoad(const Road& road, double along, double lateral);

// Returns the sign for vehicles that come out of a side road; none: there is no sign.
std::optional<models::TrafficSign> signAtMouth(const Layout& l, std::uint32_t sideRoad);

void placeHouses(Placer& placer);
void placeBoundaries(Placer& placer);
void placeMarkings(Placer& placer);
void placeCovers(Placer& placer);
void placeFixtures(Placer& placer);
void placeWires(Placer& placer);
void placeClutter(Placer& placer);
void placeAnimals(Placer& placer);
void placeVehicles(Placer& placer);  // stationary vehicles first, then those that drive
void placePeople(Placer& placer);
void placeTrees(Placer& placer);
void placeWoods(Placer& placer);
void placeBushes(Placer& placer);
void placeGrass(Placer& placer);

}  // namespace scanmill::town
