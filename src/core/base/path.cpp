#include "base/path.h"

#include <algorithm>
#include <array>

namespace scanmill {

// Integrates the derivative's length by Gauss-Legendre quadrature, five points (Abramowitz and Stegun, table 25.4).
double Path::Segment::lengthOf(double from, double to) const {
  constexpr std::array<double, 5> kNode = {0.0, -0.538469310105683, 0.538469310105683, -0.906179845938664,
                                           0.906179845938664};
  constexpr std::array<double, 5> kWeight = {0.568888888888889, 0.478628670499366, 0.478628670499366, 0.236926885056189,
                                             0.236926885056189};
  const double half = (to - from) / 2;
  const double middle = (to + from) / 2;
  double sum = 0;
  for (std::size_t i = 0; i < kNode.size(); ++i)
    sum += kWeight[i] * scanmill::length(derivative(middle + half * kNode[i]));
  return sum * half;
}

Path::Path(const std::vector<Vec3d>& points) {
  const std::size_t count = points.size() - 1;
  // The knots are centripetal: between two points the parameter grows by the square root of the chord's length.
  std::vector<double> knot(count);  // growth of the parameter from each point to the next
  std::vector<Vec3d> slope(count);  // chord divided by the growth of the parameter
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d chord = points[i + 1] - points[i];
    knot[i] = std::sqrt(scanmill::length(chord));
    slope[i] = chord * (1 / knot[i]);
  }
  std::vector<Vec3d> tangent(points.size());
  tangent.front() = slope.front();
  tangent.back() = slope.back();
  for (std::size_t i = 1; i < count; ++i) {
    const Vec3d across = (points[i + 1] - points[i - 1]) * (1 / (knot[i - 1] + knot[i]));
    tangent[i] = slope[i - 1] - across + slope[i];
  }

  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d chord = points[i + 1] - points[i];
    const Vec3d start = tangent[i] * knot[i];
    const Vec3d end = tangent[i + 1] * knot[i];
    partOfPoint_.push_back(segments_.size() * kParts);
    add({points[i], start, chord * 3 - start * 2 - end, start + end - chord * 2});
  }
  partOfPoint_.push_back(segments_.size() * kParts);
}

namespace {
constexpr double kShortest = 1e-9;  // m; a shorter straight line is left out
}

Path Path::lines(const std::vector<Vec3d>& points, double rounding) {
  Path path;
  const auto addLine = [&](const Vec3d& from, const Vec3d& to) {
    if (scanmill::length(to - from) > kShortest) path.add({from, to - from, {}, {}});
  };
  Vec3d position = points.front();  // end of the path so far
  path.partOfPoint_.push_back(0);
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const Vec3d& corner = points[i];
    const Vec3d toPrevious = points[i - 1] - corner;
    const Vec3d toNext = points[i + 1] - corner;
    const double cut = std::min({rounding, scanmill::length(toPrevious) / 2, scanmill::length(toNext) / 2});
    const Vec3d start = corner + normalized(toPrevious) * cut;
    const Vec3d end = corner + normalized(toNext) * cut;
    addLine(position, start);
    path.partOfPoint_.push_back(path.segments_.size() * kParts + kParts / 2);
    // Adds the quadratic Bezier curve of start, corner and end.
    path.add({start, (corner - start) * 2, start - corner * 2 + end, {}});
    position = end;
  }
  addLine(position, points.back());
  path.partOfPoint_.push_back(path.segments_.size() * kParts);
  return path;
}

void Path::add(const Segment& segment) {
  segments_.push_back(segment);
  for (std::size_t part = 0; part < kParts; ++part) {
    const double from = static_cast<double>(part) / kParts;
    distances_.push_back(distances_.back() + segment.lengthOf(from, from + 1.0 / kParts));
  }
}

Pose Path::pose(double distance) const {
  distance = std::clamp(distance, 0.0, length());
  const auto after = std::upper_bound(distances_.begin() + 1, distances_.end() - 1, distance);
  const std::size_t part = static_cast<std::size_t>(after - distances_.begin()) - 1;
  const Segment& segment = segments_[part / kParts];
  const double from = static_cast<double>(part % kParts) / kParts;

  // Finds u by Newton's method: the distance from the start of the part is a smooth and increasing function of u.
  const double distanceInPart = distance - distances_[part];
  double u = from + distanceInPart / (distances_[part + 1] - distances_[part]) / kParts;
  for (int i = 0; i < 4; ++i) {
    u -= (segment.lengthOf(from, u) - distanceInPart) / scanmill::length(segment.derivative(u));
    u = std::clamp(u, from, from + 1.0 / kParts);
  }
  const Vec3d heading = segment.derivative(u);
  const double yaw = std::atan2(heading.y, heading.x);
  const double pitch = -std::atan2(heading.z, std::hypot(heading.x, heading.y));
  return {fromYawPitchRoll(yaw, pitch, 0), segment.position(u)};
}

double Path::curvature(double distance, double reach) const {
  const double from = std::clamp(distance - reach, 0.0, length());
  const double to = std::clamp(distance + reach, 0.0, length());
  const Vec3d a = toMatrix(pose(from).rotation).x;
  const Vec3d b = toMatrix(pose(to).rotation).x;
  return std::atan2(a.x * b.y - a.y * b.x, a.x * b.x + a.y * b.y) / (to - from);
}

}  // namespace scanmill
