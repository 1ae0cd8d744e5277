#pragma once

// A curve through waypoints, measured by the distance travelled along it.

#include <cstddef>
#include <vector>

#include "base/vec.h"

namespace scanmill {

// A path is either a centripetal Catmull-Rom spline, or straight lines from point to point with rounded corners. The
// spline passes through every point and never has a loop or cusp between two points. Its heading is continuous, since
// the tangent at a point bisects the directions before and after it. Yuksel, Schaefer, Keyser, "Parameterization and
// applications of Catmull-Rom curves", Computer-Aided Design 43(7), 2011.
class Path {
 public:
  // Creates the spline through two or more points (m). Consecutive points must differ, and no turn may be straight
  // back.
  explicit Path(const std::vector<Vec3d>& points);
  // Creates the straight lines through at least two points (m). A parabola rounds each corner: it begins and ends
  // `rounding` metres (above 0) from the corner, or at half the distance to the nearer neighbouring point if this half
  // is shorter. A right-angled corner is missed by 0.35 times this length.
  static Path lines(const std::vector<Vec3d>& points, double rounding);

  double length() const { return distances_.back(); }  // length of the path (m)
  // Returns the pose at a distance along the path (m): x heads along the path, without roll. A distance before the
  // start or beyond the end gives the pose at that end.
  Pose pose(double distance) const;
  // Returns the mean signed curvature in the horizontal plane (1/m; positive in left turns) of the part of the path
  // from distance - reach to distance + reach (m): its change of heading, divided by its length.
  double curvature(double distance, double reach) const;
  // Returns the distance along the path (m) at which the path passes the waypoint with this index, or is nearest to it
  // if the corner is rounded.
  double distanceOfPoint(std::size_t point) const { return distances_[partOfPoint_[point]]; }

 private:
  // position = a + u (b + u (c + u d)), u in [0, 1].
  struct Segment {
    Vec3d a, b, c, d;
    Vec3d position(double u) const { return a + (b + (c + d * u) * u) * u; }
    Vec3d derivative(double u) const { return b + (c * 2 + d * (3 * u)) * u; }
    // Returns the length (m) of the curve between two values of u.
    double lengthOf(double from, double to) const;
  };
  static constexpr std::size_t kParts = 16;  // number of parts of a segment, of equal steps of u

  Path() = default;
  void add(const Segment& segment);

  std::vector<Segment> segments_;
  std::vector<double> distances_{0};  // m along the path to the start of each part (kParts per segment) and to the end
  std::vector<std::size_t> partOfPoint_;  // for each waypoint, its index into distances_
};

}  // namespace scanmill
