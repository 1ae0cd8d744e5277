#pragma once

// From degrees to metres, as maps of a few kilometres need it.

#include "base/vec.h"
#include "models/models.h"
#include "town/osm.h"

namespace scanmill::town {

// The plane that touches the WGS 84 ellipsoid at a point (degrees): x east, y north, or south in its mirror image, in
// metres from there, by
// earth-centred coordinates. At 25 km from the point it is 0.1 m short.
class TangentPlane {
 public:
  TangentPlane(double latitude, double longitude, bool mirrored = false);

  models::Point2 operator()(const OsmNode& n) const;
  bool mirrored() const { return north_ < 0; }
  // The other way round.
  OsmNode degreesAt(const models::Point2& p) const;

 private:
  double latitude_, longitude_;  // rad
  double north_;                 // which way y goes for it: 1 or -1
  Vec3d origin_;
};

}  // namespace scanmill::town
