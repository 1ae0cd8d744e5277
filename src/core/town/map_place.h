#pragma once

// The part of a map from which a town is laid out: a part of one road and its surroundings.

#include <string>
#include <vector>

#include "town/character.h"
#include "town/map.h"

namespace scanmill::town {

// A square of a map, with its contents in a frame of its own (m; x east, y north).
struct MapPlace : MapContents {
  OsmNode origin;  // origin of the place's frame, on the main road
  // The main road comes first. Lines are smoothed, in steps of about kRoadStep; roads have no nodes.
  std::vector<MapRoad> roads;
  std::vector<Point2> joints;         // points where roads meet
  double mainFrom = 0, mainTo = 0;    // m along the main road, the ends of its built-up part
  std::string district = "suburban";  // value of the key `district`
};

// Returns a square of the map around a random point of the main road. The main road is the road that the parameters
// name, or else a random road. `reach` is half of the side of the square (m). Throws an InputError at `where` for a
// name that no road has, or if no road is long enough.
MapPlace cutOut(const Map& map, const Parameters& parameters, std::uint64_t seed, double reach, const Location& where);

}  // namespace scanmill::town
