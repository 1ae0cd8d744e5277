#pragma once

// The part of a map that a town is laid out from: a stretch of one of its roads and what lies about it.

#include <string>
#include <vector>

#include "town/character.h"
#include "town/map.h"

namespace scanmill::town {

struct MapPlace {
  struct PlacedRoad {
    MapRoad road;                 // its line smooth, in steps of about kRoadStep; its nodes are gone
    std::optional<double> joins;  // m along the main road where it begins; none: elsewhere
    bool joinsLeft = false;
  };

  OsmNode origin;                   // of the frame, on the main road
  std::vector<PlacedRoad> roads;    // the main road first
  std::vector<Point2> joints;       // where roads meet
  double mainFrom = 0, mainTo = 0;  // m along the main road
  District district = District::Suburban;
  // Moved to the place's frame, x east and y north, as far as they reach into it.
  std::vector<std::vector<Point2>> paths;
  std::vector<MapBuilding> buildings;
  std::vector<MapArea> areas;
  std::vector<MapBarrier> barriers;
  std::vector<Point2> trees;
};

// The road that the parameters name, or one that the seed draws, and where along it the place lies. `reach` is half of
// the side of the square that is taken (m). Throws an InputError at `where` for a name that no road has, or where no
// road is long enough.
MapPlace cutOut(const Map& map, const Parameters& parameters, std::uint64_t seed, double reach, const Location& where);

}  // namespace scanmill::town
