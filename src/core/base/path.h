#pragma once

// A smooth curve through waypoints, measured by the distance travelled along it.

#include <cstddef>
#include <vector>

#include "base/vec.h"

namespace scanmill {

// A centripetal Catmull-Rom spline: it passes every point, never loops or cusps between two of them, and its heading is
// continuous, since the tangent at a point bisects the directions before and after it. Yuksel, Schaefer, Keyser,
// "Parameterization and applications of Catmull-Rom curves", Computer-Aided Design 43(7), 2011.
class Path {
 public:
  // `points` are in metres, two at least. Consecutive ones must differ, and the path must not turn straight back.
  explicit Path(const std::vector<Vec3d>& points);

  double length() const { return travelled_.back(); }  // m
  // The pose at a distance along the path (m): x heads along the path, without roll. A distance before or after the
  // path gives its end.
  Pose pose(double distance) const;
  // How much the heading over ground turns to the left for each metre along the path, by the headings `reach` metres
  // before and behind a place (1/m).
  double curvature(double distance, double reach) const;
  // The distance along the path at which it passes one of its points (m).
  double distanceOfPoint(std::size_t point) const { return travelled_[point * kParts]; }

 private:
  // position = a + u (b + u (c + u d)), u in [0, 1].
  struct Segment {
    Vec3d a, b, c, d;
    Vec3d position(double u) const { return a + (b + (c + d * u) * u) * u; }
    Vec3d derivative(double u) const { return b + (c * 2 + d * (3 * u)) * u; }
    double travelled(double from, double to) const;
  };
  static constexpr std::size_t kParts = 16;

  std::vector<Segment> segments_;
  std::vector<double> travelled_;  // m, at the start of each of the kParts equal parts of each segment, and at the end
};

}  // namespace scanmill
