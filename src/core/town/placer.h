#pragma once

// Puts things on the ground of a town, where nothing else stands.

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
  static constexpr double kGap = 0.15;  // least distance between things, m

  Placer(SceneBuilder& builder, const Layout& layout, const Affine& worldFromTown);

  // Upright, its origin on the ground or `sink` below it.
  void put(const Model& m, const Spot& s, const std::string& name, double sink = 0);
  // False where something stands there already.
  bool tryPut(const Model& m, const Spot& s, const std::string& name, double sink = 0);
  // The same of what stands on wheels, which tilts as the ground does.
  bool tryPark(const Model& m, const Spot& s, const std::string& name);
  // Whatever stands there.
  void park(const Model& m, const Spot& s, const std::string& name);

  static Footprint footprint(const Model& m, const Spot& s, double grow);

  SceneBuilder& builder;
  const Layout& layout;
  const Affine& worldFromTown;
  // Whether it is on the ground, and neither on a driveway or path nor where something stands.
  bool isFree(const Footprint& f) const {
    constexpr double kEdge = 3;  // m
    const double reach = layout.half() - kEdge;
    return std::abs(f.center.x) < reach && std::abs(f.center.y) < reach && driveways.isFree(f) && occupancy.isFree(f);
  }

  models::Occupancy occupancy;  // by things that stand
  models::Occupancy driveways;  // and paths: they stay clear
  models::Occupancy noParking;  // where nothing on wheels may stand
  // Traffic lights of the main road, for those who drive against its line.
  struct Light {
    static constexpr double kPeriod = 44;  // s
    static constexpr double kRed = 16;     // s of the period
    double along;                          // where they stop, m
    double offset;                         // s, in its period
    bool marked;                           // by a line on the road
  };
  std::vector<Light> lights;

 private:
  Vec3d onGround(const Point2& p, double sink) const;
};

// A place beside a road, by the distance along its line and from it to the left; the yaw is the line's.
Spot besideRoad(const Road& road, double along, double lateral);

// What those obey who come out of a side road.
std::optional<models::TrafficSign> signAtMouth(const Layout& l, std::uint32_t sideRoad);

void placeHouses(Placer& placer);
void placeBoundaries(Placer& placer);
void placeMarkings(Placer& placer);
void placeCovers(Placer& placer);
void placeFixtures(Placer& placer);
void placeWires(Placer& placer);
void placeClutter(Placer& placer);
void placeAnimals(Placer& placer);
void placeVehicles(Placer& placer);  // those that stand, then those that drive
void placePeople(Placer& placer);
void placeTrees(Placer& placer);
void placeWoods(Placer& placer);
void placeBushes(Placer& placer);
void placeGrass(Placer& placer);

}  // namespace scanmill::town
