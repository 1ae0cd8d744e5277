#pragma once

// Finds free places on the street and places objects there.

#include <string>
#include <utility>
#include <vector>

#include "models/occupancy.h"
#include "town/street/layout.h"

namespace scanmill::street {

struct Spot {
  double x = 0, y = 0, yaw = 0, scale = 1;
  double lean = 0;  // roll about x, radians
};

struct Placer {
  static constexpr int kTries = 24;
  static constexpr double kGap = 0.15;  // least distance between objects, m

  // Returns the rectangle that a placed model covers; `grow` enlarges it on all sides.
  static Footprint footprint(const Model& m, const Spot& s, double grow);

  void put(const Model& m, const Spot& s, std::string name, double sink = 0);
  // Places the model if the place is free, otherwise returns false.
  bool tryPut(const Model& m, const Spot& s, std::string name, double sink = 0);
  // Calls choose() until its place is free, at most kTries times; returns false if none is.
  template <class Choose>
  bool search(const Model& m, const std::string& name, Choose choose, double sink = 0) {
    for (int k = 0; k < kTries; ++k) {
      if (tryPut(m, choose(), name, sink)) return true;
    }
    return false;
  }

  double alongStreet(Draw& draw, double margin) const;
  bool nearCrossing(double x, double margin) const;
  // Returns the distance at x from the centre line to the edge of the sidewalk at the road.
  double walkFrom(double x) const;
  // Returns a random place on a sidewalk, away from the crossing, driveways and paths. `from` is the place's distance
  // from the sidewalk's edge at the road or, if negative, from the other edge (m).
  Spot onSidewalk(Draw& draw, double from, double margin) const;

  SceneBuilder& builder;
  const Layout& layout;
  const Affine& worldFromStreet;
  Occupancy occupancy;
};

// Each kind of object has its own random stream. An object that finds no free place after some tries is left out.
void placeTrafficLights(Placer& placer);
void placeBoundaries(Placer& placer);
void placeLamps(Placer& placer);
void placeSigns(Placer& placer);
void placeShelters(Placer& placer);
void placeFurniture(Placer& placer);
// Places parked cars and motorcycles, vehicles in traffic (named "traffic ...") and cyclists; only the last two are
// placed on the lanes.
void placeVehicles(Placer& placer);
void placeBicycles(Placer& placer);
void placeTrees(Placer& placer);
void placeBushes(Placer& placer);
void placePedestrians(Placer& placer);

}  // namespace scanmill::street
