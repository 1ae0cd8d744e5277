#pragma once

// From degrees to metres, as maps of a few kilometres need it.

#include "base/vec.h"
#include "scene/parts/parts.h"
#include "scene/town/osm.h"

namespace scanmill::town {

// The plane that touches the WGS 84 ellipsoid at a point (degrees): x east, y north, in metres from there, by
// earth-centred coordinates. At 25 km from the point it is 0.1 m short.
class TangentPlane {
 public:
  TangentPlane(double latitude, double longitude);

  parts::Point2 operator()(const OsmNode& n) const;
  // The other way round.
  OsmNode degreesAt(const parts::Point2& p) const;

 private:
  double latitude_, longitude_;  // rad
  Vec3d origin_;
};

}  // namespace scanmill::town
