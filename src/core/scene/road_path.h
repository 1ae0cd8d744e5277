#pragma once

// Finds a path for a vehicle on the surfaces of a scene, from one point to another.
//
//   const RoadTrip trip{.classes = {"road"}, .from = {0, 0, 0}, .to = {80, 40, 0}};
//   const std::vector<Vec3d> path = findRoadPath(heights, scene.ontology, trip);

#include <string>
#include <vector>

#include "base/vec.h"
#include "config/value.h"
#include "scene/ontology.h"
#include "scene/surface_heights.h"

namespace scanmill {

class Fields;

enum class RoadSide { Right, Left, Middle };

struct RoadTrip {
  std::vector<std::string> classes;  // names of the classes of surfaces to drive on
  Vec3d from, to;                    // m, world frame; a height of 0 means any height
  RoadSide keep = RoadSide::Right;   // side of the road on which the vehicle drives
  Location where = {};               // place in the YAML, for messages
};

// Reads the key `keep` (right, left or middle) of a map; right if the key is absent. Throws InputError.
RoadSide readRoadSide(Fields& fields);
// Reads {from: [x, y], to: [x, y], on: road, keep: right} from the keys of a map; a point may have a height. Throws
// InputError.
RoadTrip readRoadTrip(Fields& fields);

// Returns the points (m) of a path on surfaces of the trip's classes, about 2 m apart, from the surface nearest to
// `trip.from` to the surface nearest to `trip.to`. A vehicle 2 m wide and 2.5 m high has room at every point. The path
// is the cheapest on cells of 1 m (A*: Hart, Nilsson and Raphael, IEEE Trans. Systems Science and Cybernetics 4, 1968),
// with surcharges beside edges and obstacles. It is then smoothed, and moved sideways to 2 m from the edge on the
// trip's side, or to the middle of roads less than 4 m wide; it is not moved where an edge is more than 12 m away.
// Throws InputError if there is no path, or no such surface within 20 m of one of the two points.
std::vector<Vec3d> findRoadPath(const SurfaceHeights& heights, const Ontology& ontology, const RoadTrip& trip);

// Returns points about 1 m apart on the straight lines between the given points, each moved vertically to the ground
// under it. Any surface that is not a thing is ground. Throws InputError if a point has no ground.
std::vector<Vec3d> droppedOnGround(const SurfaceHeights& heights, const std::vector<Vec3d>& points,
                                   const Location& where);

}  // namespace scanmill
