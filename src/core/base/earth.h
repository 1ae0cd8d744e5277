#pragma once

// Positions on the earth in the coordinates of 3D Tiles: WGS 84 (EPSG 4979), or earth-centred in metres (EPSG 4978).

#include "base/vec.h"

namespace scanmill {

constexpr double kEarthRadius = 6378137;  // m, semi-major axis of the ellipsoid of WGS 84

// Returns the earth-centred coordinates (m) of a longitude and latitude (rad) and a height above the ellipsoid (m).
Vec3d earthCentred(double longitude, double latitude, double height);

// True if a point in earth-centred coordinates (m) is 6200 to 6600 km from the earth's centre, as the surface is.
bool isOnEarth(const Vec3d& point);

// Returns the transform from earth-centred coordinates to x east, y north, z up with the origin at `point`. Up is the
// normal of the ellipsoid.
Affine eastNorthUp(const Vec3d& point);

}  // namespace scanmill
