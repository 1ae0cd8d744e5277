#include "base/earth.h"

#include <cmath>

namespace scanmill {
namespace {

constexpr double kFlattening = 1 / 298.257223563;
constexpr double kEccentricity2 = kFlattening * (2 - kFlattening);

}  // namespace

Vec3d earthCentred(double longitude, double latitude, double height) {
  const double s = std::sin(latitude);
  const double n = kEarthRadius / std::sqrt(1 - kEccentricity2 * s * s);
  const double out = (n + height) * std::cos(latitude);
  return {out * std::cos(longitude), out * std::sin(longitude), (n * (1 - kEccentricity2) + height) * s};
}

bool isOnEarth(const Vec3d& place) {
  const double far = length(place);
  return far > 6.2e6 && far < 6.6e6;
}

Affine eastNorthUp(const Vec3d& place) {
  // Finds the geodetic latitude by fixed-point iteration, which gains at least two digits per step near the surface.
  const double longitude = std::atan2(place.y, place.x);
  const double out = std::hypot(place.x, place.y);
  double latitude = std::atan2(place.z, out * (1 - kEccentricity2));
  for (int i = 0; i < 8; ++i) {
    const double s = std::sin(latitude);
    const double n = kEarthRadius / std::sqrt(1 - kEccentricity2 * s * s);
    latitude = std::atan2(place.z + kEccentricity2 * n * s, out);
  }
  const double sl = std::sin(longitude), cl = std::cos(longitude);
  const double sp = std::sin(latitude), cp = std::cos(latitude);
  const Mat3 earthFromLocal{{-sl, cl, 0}, {-sp * cl, -sp * sl, cp}, {cp * cl, cp * sl, sp}};
  const Mat3 localFromEarth = transposed(earthFromLocal);
  return {localFromEarth, -(localFromEarth * place)};
}

}  // namespace scanmill
