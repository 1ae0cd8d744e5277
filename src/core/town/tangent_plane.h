#pragma once

// Converts degrees to metres for maps of a few kilometres.

#include "base/vec.h"
#include "models/models.h"
#include "town/osm.h"

namespace scanmill::town {

// The plane that touches the WGS 84 ellipsoid at a point (degrees). Coordinates are metres from that point: x east, y
// north (south if mirrored). Conversion uses earth-centred coordinates; 25 km from the point, distances in the plane
// are 0.1 m too short.
class TangentPlane {
 public:
  TangentPlane(double latitude, double longitude, bool mirrored = false);

  models::Point2 operator()(const OsmNode& n) const;
  bool mirrored() const { return north_ < 0; }
  // Returns the latitude and longitude (degrees) of a point in the plane: the inverse of operator().
  OsmNode degreesAt(const models::Point2& p) const;

 private:
  double latitude_, longitude_;  // rad
  double north_;                 // sign of y towards the north: 1, or -1 if mirrored
  Vec3d origin_;
};

}  // namespace scanmill::town
