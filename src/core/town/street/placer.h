#pragma once

// Finds free places on the street and puts things there.

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
  static constexpr double kGap = 0.15;  // least distance between things, m

  // The rectangle that a placed model covers; `grow` enlarges it on all sides.
  static Footprint footprint(const Model& m, const Spot& s, double grow);

  void put(const Model& m, const Spot& s, std::string name, double sink = 0);
  // False where something stands there already.
  bool tryPut(const Model& m, const Spot& s, std::string name, double sink = 0);
  // Asks for spots until one is free.
  template <class Choose>
  bool search(const Model& m, const std::string& name, Choose choose, double sink = 0) {
    for (int k = 0; k < kTries; ++k) {
      if (tryPut(m, choose(), name, sink)) return true;
    }
    return false;
  }

  double alongStreet(Draw& draw, double margin) const;
  bool nearCrossing(double x, double margin) const;
  // Distance from the centre line to the road's side of the sidewalk, at x.
  double walkFrom(double x) const;
  // A place on a sidewalk, away from the crossing, driveways and paths. `from` is its distance from the sidewalk's edge
  // at the road or, where it is negative, from the other edge (m).
  Spot onSidewalk(Draw& draw, double from, double margin) const;

  SceneBuilder& builder;
  const Layout& layout;
  const Affine& worldFromStreet;
  Occupancy occupancy;
};

// Each kind has its own random numbers; where an object finds no free place after some tries, it is left out.
void placeTrafficLights(Placer& placer);
void placeBoundaries(Placer& placer);
void placeLamps(Placer& placer);
void placeSigns(Placer& placer);
void placeShelters(Placer& placer);
void placeFurniture(Placer& placer);
// Parked cars and motorcycles, vehicles in traffic (named "traffic ..."), cyclists: all that stands on the lanes is
// traffic or a cyclist.
void placeVehicles(Placer& placer);
void placeBicycles(Placer& placer);
void placeTrees(Placer& placer);
void placeBushes(Placer& placer);
void placePedestrians(Placer& placer);

}  // namespace scanmill::street
