#include "town/tangent_plane.h"

#include <algorithm>
#include <cmath>

namespace scanmill::town {
namespace {

using models::Point2;

// Returns the earth-centred position (m) of a point on the ellipsoid, given by latitude and longitude (rad).
Vec3d earthCentred(double latitude, double longitude) {
  constexpr double kRadius = 6378137;  // m, WGS 84
  constexpr double kFlattening = 1 / 298.257223563;
  constexpr double kSquare = kFlattening * (2 - kFlattening);
  const double across = kRadius / std::sqrt(1 - kSquare * std::sin(latitude) * std::sin(latitude));
  return {across * std::cos(latitude) * std::cos(longitude), across * std::cos(latitude) * std::sin(longitude),
          across * (1 - kSquare) * std::sin(latitude)};
}

}  // namespace

TangentPlane::TangentPlane(double latitude, double longitude, bool mirrored)
    : latitude_(radians(latitude)),
      longitude_(radians(longitude)),
      north_(mirrored ? -1 : 1),
      origin_(earthCentred(latitude_, longitude_)) {}

Point2 TangentPlane::operator()(const OsmNode& n) const {
  const Vec3d d = earthCentred(radians(n.latitude), radians(n.longitude)) - origin_;
  const double towards = d.x * std::cos(longitude_) + d.y * std::sin(longitude_);
  return {d.y * std::cos(longitude_) - d.x * std::sin(longitude_),
          north_ * (d.z * std::cos(latitude_) - towards * std::sin(latitude_))};
}

// Solves by Newton's method with an approximate derivative: anywhere in the plane, a metre to the north or east is
// about the same number of degrees.
OsmNode TangentPlane::degreesAt(const Point2& p) const {
  constexpr double kDegree = 111300;  // m, length of a degree of latitude
  OsmNode node{0, degrees(latitude_), degrees(longitude_)};
  for (int i = 0; i < 12; ++i) {
    const Point2 now = (*this)(node);
    node.latitude += north_ * (p.y - now.y) / kDegree;
    node.longitude += (p.x - now.x) / (kDegree * std::max(0.01, std::cos(latitude_)));
  }
  return node;
}

}  // namespace scanmill::town
