#pragma once

// A curve through waypoints, measured by the distance travelled along it.

#include <cstddef>
#include <vector>

#include "base/vec.h"

namespace scanmill {

// Either a centripetal Catmull-Rom spline: it passes every point, never loops or cusps between two of them, and its
// heading is continuous, since the tangent at a point bisects the directions before and after it. Yuksel, Schaefer,
// Keyser, "Parameterization and applications of Catmull-Rom curves", Computer-Aided Design 43(7), 2011. Or straight
// lines from point to point, whose corners are rounded.
class Path {
 public:
  // The spline. `points` are in metres, two at least. Consecutive ones must differ, and the path must not turn straight
  // back.
  explicit Path(const std::vector<Vec3d>& points);
  // The straight lines through such points. A corner is rounded by a parabola that leaves the lines `rounding` metres
  // (above 0) before and behind it, or half of the way to the next point where that is less; a right angle is passed
  // 0.35 of that away.
  static Path lines(const std::vector<Vec3d>& points, double rounding);

  double length() const { return travelled_.back(); }  // m
  // The pose at a distance along the path (m): x heads along the path, without roll. A distance before or after the
  // path gives its end.
  Pose pose(double distance) const;
  // How much the heading over ground turns to the left for each metre along the path, by the headings `reach` metres
  // before and behind a place (1/m).
  double curvature(double distance, double reach) const;
  // The distance along the path at which it passes one of its points (m), or is nearest to a corner that it rounds.
  double distanceOfPoint(std::size_t point) const { return travelled_[partOfPoint_[point]]; }

 private:
  // position = a + u (b + u (c + u d)), u in [0, 1].
  struct Segment {
    Vec3d a, b, c, d;
    Vec3d position(double u) const { return a + (b + (c + d * u) * u) * u; }
    Vec3d derivative(double u) const { return b + (c * 2 + d * (3 * u)) * u; }
    double travelled(double from, double to) const;
  };
  static constexpr std::size_t kParts = 16;

  Path() = default;
  void add(const Segment& segment);

  std::vector<Segment> segments_;
  std::vector<double> travelled_{0};  // m, at the start of each of the kParts equal parts of each segment, and at the
                                      // end
  std::vector<std::size_t> partOfPoint_;  // index into travelled_
};

}  // namespace scanmill
