#pragma once

// Places on the earth, as 3D Tiles has them: WGS 84 (EPSG 4979), earth-centred coordinates in metres (EPSG 4978).

#include "base/vec.h"

namespace scanmill {

// Longitude and latitude in radians, height above the ellipsoid in metres.
Vec3d earthCentred(double longitude, double latitude, double height);

// Whether a place is about as far from the earth's centre as its surface.
bool isOnEarth(const Vec3d& place);

// From earth-centred coordinates to x east, y north, z up about a place there. Up is square to the ellipsoid.
Affine eastNorthUp(const Vec3d& place);

}  // namespace scanmill
