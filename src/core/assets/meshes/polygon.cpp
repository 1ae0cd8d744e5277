#include "assets/meshes/polygon.h"

#include <cmath>
#include <numeric>

#include "assets/meshes/asset_parts.h"

namespace scanmill {

namespace {

struct Point {
  double x = 0, y = 0;
  bool operator==(const Point&) const = default;
};

// Returns twice the signed area of a triangle, which is positive if its corners are counter-clockwise.
double areaOf(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Projects at least three corners to 2D along the main axis of the polygon's area vector, with x and y swapped if the
// outline would run clockwise.
std::vector<Point> flattened(const std::vector<Vec3d>& corners) {
  Vec3d area;
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    area = area + cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
  }
  const double x = std::abs(area.x), y = std::abs(area.y), z = std::abs(area.z);
  std::vector<Point> points;
  points.reserve(corners.size());
  for (const Vec3d& corner : corners) {
    const Vec3d p = corner - corners[0];
    if (z >= x && z >= y) {
      points.push_back(area.z < 0 ? Point{p.y, p.x} : Point{p.x, p.y});
    } else if (y >= x) {
      points.push_back(area.y < 0 ? Point{p.x, p.z} : Point{p.z, p.x});
    } else {
      points.push_back(area.x < 0 ? Point{p.z, p.y} : Point{p.y, p.z});
    }
  }
  return points;
}

class EarCutter {
 public:
  EarCutter(const std::vector<Vec3d>& corners, std::vector<std::array<std::uint32_t, 3>>& triangles, double& tests)
      : points_(flattened(corners)), uncut_(corners.size()), triangles_(triangles), tests_(tests) {
    std::iota(uncut_.begin(), uncut_.end(), 0u);
  }

  // Appends the polygon's triangles. Returns false, with some missing, if `tests_` exceeds `mostTests`.
  bool cut(double mostTests) {
    // The search begins at corner 1, so that a convex polygon becomes the usual fan about corner 0. Only after a round
    // over all corners without an ear, corners between collinear edges are cut off too.
    for (std::size_t at = 1, rejected = 0; uncut_.size() > 3 && rejected < 2 * uncut_.size();) {
      if (tests_ > mostTests) return false;
      if (!isDouble(at) && !isEar(at) && !(rejected >= uncut_.size() && isFlat(at))) {
        at = (at + 1) % uncut_.size();
        ++rejected;  // number of successive corners that cannot be cut off
        continue;
      }
      triangles_.push_back({before(at), uncut_[at], behind(at)});
      uncut_.erase(uncut_.begin() + static_cast<std::ptrdiff_t>(at));
      at %= uncut_.size();
      rejected = 0;
    }
    for (std::size_t i = 1; i + 1 < uncut_.size(); ++i) triangles_.push_back({uncut_[0], uncut_[i], uncut_[i + 1]});
    return true;
  }

 private:
  // All functions below take an index into uncut_; before() and behind() return the corners beside it.
  std::uint32_t before(std::size_t at) const { return uncut_[(at + uncut_.size() - 1) % uncut_.size()]; }
  std::uint32_t behind(std::size_t at) const { return uncut_[(at + 1) % uncut_.size()]; }

  bool isFlat(std::size_t at) const {
    return areaOf(points_[before(at)], points_[uncut_[at]], points_[behind(at)]) == 0;
  }

  // True if two of three corners coincide: the corner `at` and its two neighbours. If the neighbours coincide, the
  // outline leads to the corner `at` and back on the same edge.
  bool isDouble(std::size_t at) const {
    const Point &a = points_[before(at)], &b = points_[uncut_[at]], &c = points_[behind(at)];
    return a == b || b == c || a == c;
  }

  // True if an edge from the corner `at`, whose position is b, leads into the angle at b between c and a.
  bool entersAt(std::size_t at, const Point& a, const Point& b, const Point& c) const {
    const auto enters = [&](const Point& end) { return areaOf(b, c, end) > 0 && areaOf(b, end, a) > 0; };
    return enters(points_[before(at)]) || enters(points_[behind(at)]);
  }

  // True if the corner is convex, its triangle contains no other corner of uncut_, and no edge enters the triangle at
  // one of its corners, which a polygon that touches itself may pass several times.
  bool isEar(std::size_t at) {
    const Point& a = points_[before(at)];
    const Point& b = points_[uncut_[at]];
    const Point& c = points_[behind(at)];
    if (!(areaOf(a, b, c) > 0)) return false;
    for (std::size_t i = 0; i < uncut_.size(); ++i) {
      ++tests_;
      if (uncut_[i] == before(at) || uncut_[i] == uncut_[at] || uncut_[i] == behind(at)) continue;
      const Point& p = points_[uncut_[i]];
      if (p == a || p == b || p == c) {
        if (p == a ? entersAt(i, c, a, b) : p == b ? entersAt(i, a, b, c) : entersAt(i, b, c, a)) return false;
      } else if (areaOf(a, b, p) >= 0 && areaOf(b, c, p) >= 0 && areaOf(c, a, p) >= 0) {
        return false;
      }
    }
    return true;
  }

  std::vector<Point> points_;         // the corners of the polygon, projected
  std::vector<std::uint32_t> uncut_;  // corners that have not been cut off, in order
  std::vector<std::array<std::uint32_t, 3>>& triangles_;
  double& tests_;
};

}  // namespace

const std::vector<std::array<std::uint32_t, 3>>& Triangulator::divide(std::size_t n,
                                                                      const std::function<Vec3d(std::size_t)>& corner) {
  allTriangles_ += n - 2;
  if (allTriangles_ > kMostTriangles) {
    throw InputError(where_, "has more than {} triangles: split it", kMostTriangles);
  }
  triangles_.assign(1, {0, 1, 2});
  if (n == 3) return triangles_;
  triangles_.clear();
  polygon_.clear();
  for (std::size_t i = 0; i < n; ++i) polygon_.push_back(corner(i));
  // Each ear is compared with all corners that are not cut off yet.
  const double fewestTests = static_cast<double>(n) * static_cast<double>(n) / 2;
  if (tests_ + fewestTests >= mostTests_ || !EarCutter(polygon_, triangles_, tests_).cut(mostTests_)) {
    throw InputError(where_,
                     "has polygons of up to {} corners, which would take minutes to divide into "
                     "triangles: export it with triangles",
                     n);
  }
  return triangles_;
}

}  // namespace scanmill
