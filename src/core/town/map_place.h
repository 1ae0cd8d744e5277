#pragma once

// The part of a map that a town is laid out from: a part of one of its roads and its surroundings.

#include <string>
#include <vector>

#include "town/character.h"
#include "town/map.h"

namespace scanmill::town {

struct MapPlace {
  struct PlacedRoad {
    MapRoad road;                 // line smoothed, in steps of about kRoadStep; without nodes
    std::optional<double> joins;  // m along the main road where this road begins; none: it does not
    bool joinsLeft = false;
  };

  OsmNode origin;                   // origin of the place's frame, on the main road
  std::vector<PlacedRoad> roads;    // the main road first
  std::vector<Point2> joints;       // where roads meet
  double mainFrom = 0, mainTo = 0;  // m along the main road
  District district = District::Suburban;
  // In the place's frame, x east and y north, as far as they reach into the square.
  std::vector<std::vector<Point2>> paths;
  std::vector<MapBuilding> buildings;
  std::vector<MapArea> areas;
  std::vector<MapBarrier> barriers;
  std::vector<Point2> trees;
};

// Returns a square of the map around a point of the main road, which is the road that the parameters name or a random
// one; the point is random. `reach` is half of the side of the square (m). Throws an InputError at `where` for a name
// that no road has, or if no road is long enough.
MapPlace cutOut(const Map& map, const Parameters& parameters, std::uint64_t seed, double reach, const Location& where);

}  // namespace scanmill::town
