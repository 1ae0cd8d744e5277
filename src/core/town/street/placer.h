#pragma once

// Finds free places on the street and places objects there.

#include <string>
#include <utility>
#include <vector>

#include "models/occupancy.h"
#include "town/street/layout.h"

namespace scanmill::street {

struct Placer {
  static constexpr int kTries = 24;
  static constexpr double kGap = 0.15;  // m, least distance between objects

  void put(const Model& m, const Spot& s, std::string name, double sink = 0);
  // Places the model if the place is free. Otherwise returns false.
  bool tryPut(const Model& m, const Spot& s, std::string name, double sink = 0);
  // Calls choose() until the place that it returns is free, at most kTries times. Returns false if no place is free.
  template <class Choose>
  bool search(const Model& m, const std::string& name, Choose choose, double sink = 0) {
    for (int k = 0; k < kTries; ++k) {
      if (tryPut(m, choose(), name, sink)) return true;
    }
    return false;
  }

  double alongStreet(Draw& draw, double margin) const;
  bool nearCrossing(double x, double margin) const;
  // Returns the distance (m) from the centre line to the road-side edge of the sidewalk at x.
  double walkFrom(double x) const;
  // Returns a random place on a sidewalk, away from the crossing, driveways and paths. `from` is the distance (m) from
  // the sidewalk's edge at the road or, if negative, from its other edge.
  Spot onSidewalk(Draw& draw, double from, double margin) const;

  SceneBuilder& builder;
  const Layout& layout;
  const Affine& worldFromStreet;
  Occupancy occupancy;
};

// Each kind of object has its own random stream. An object that finds no free place is left out;
// random places are tried at most kTries times.
void placeTrafficLights(Placer& placer);
void placeBoundaries(Placer& placer);
void placeLamps(Placer& placer);
void placeSigns(Placer& placer);
void placeShelters(Placer& placer);
void placeFurniture(Placer& placer);
// Places parked cars and motorcycles, vehicles in traffic (named "traffic ...") and cyclists. Only traffic and cyclists
// are on the lanes.
void placeVehicles(Placer& placer);
void placeBicycles(Placer& placer);
void placeTrees(Placer& placer);
void placeBushes(Placer& placer);
void placePedestrians(Placer& placer);

}  // namespace scanmill::street
