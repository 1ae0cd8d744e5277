#include "base/earth.h"

#include <cmath>

namespace scanmill {
namespace {

constexpr double kFlattening = 1 / 298.257223563;
constexpr double kEccentricity2 = kFlattening * (2 - kFlattening);

// Returns the distance (m) from the surface of the ellipsoid along its normal to the polar axis (the radius of
// curvature in the prime vertical).
double normalRadius(double latitude) {
  const double s = std::sin(latitude);
  return kEarthRadius / std::sqrt(1 - kEccentricity2 * s * s);
}

}  // namespace

Vec3d earthCentred(double longitude, double latitude, double height) {
  const double radius = normalRadius(latitude);
  const double fromAxis = (radius + height) * std::cos(latitude);
  return {fromAxis * std::cos(longitude), fromAxis * std::sin(longitude),
          (radius * (1 - kEccentricity2) + height) * std::sin(latitude)};
}

bool isOnEarth(const Vec3d& point) {
  const double fromCentre = length(point);
  return fromCentre > 6.2e6 && fromCentre < 6.6e6;
}

Affine eastNorthUp(const Vec3d& point) {
  // Finds the geodetic latitude by fixed-point iteration, which gains at least two digits per step near the surface.
  const double longitude = std::atan2(point.y, point.x);
  const double fromAxis = std::hypot(point.x, point.y);
  double latitude = std::atan2(point.z, fromAxis * (1 - kEccentricity2));
  for (int i = 0; i < 8; ++i) {
    latitude = std::atan2(point.z + kEccentricity2 * normalRadius(latitude) * std::sin(latitude), fromAxis);
  }
  const double sl = std::sin(longitude), cl = std::cos(longitude);
  const double sp = std::sin(latitude), cp = std::cos(latitude);
  const Mat3 earthFromLocal{{-sl, cl, 0}, {-sp * cl, -sp * sl, cp}, {cp * cl, cp * sl, sp}};
  const Mat3 localFromEarth = transposed(earthFromLocal);
  return {localFromEarth, -(localFromEarth * point)};
}

}  // namespace scanmill
