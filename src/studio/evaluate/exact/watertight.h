#pragma once

// Intersects a beam with a triangle in double precision: Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection",
// JCGT 2(1), 2013. For triangles that share an edge, the test on which side of the edge a beam passes gives exactly the
// same result, so that no beam passes between them.

#include <cmath>
#include <utility>

#include "base/vec.h"

namespace scanmill {

struct TriangleMeet {
  double range = 0;     // distance from the beam's origin (m); 0: the beam does not hit the triangle
  double u = 0, v = 0;  // barycentric coordinates of the second and third corner
};

// A beam for intersection tests. Coordinates are permuted and sheared so that the beam runs along the z axis.
class ShearedBeam {
 public:
  ShearedBeam(const Vec3d& origin, const Vec3d& direction) : origin_(origin) {
    const Vec3d size{std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)};
    z_ = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
    x_ = (z_ + 1) % 3;
    y_ = (z_ + 2) % 3;
    const double along = component(direction, z_);
    if (along < 0) std::swap(x_, y_);  // preserves the winding order
    shearX_ = component(direction, x_) / along;
    shearY_ = component(direction, y_) / along;
    scale_ = 1 / along;
  }

  TriangleMeet meet(const Vec3d& a, const Vec3d& b, const Vec3d& c) const {
    const Vec3d p = sheared(a);
    const Vec3d q = sheared(b);
    const Vec3d r = sheared(c);
    const double u = r.x * q.y - r.y * q.x;
    const double v = p.x * r.y - p.y * r.x;
    const double w = q.x * p.y - q.y * p.x;
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return {};
    const double area = u + v + w;
    if (area == 0) return {};  // the beam lies in the triangle's plane
    const double range = (u * p.z + v * q.z + w * r.z) / area * scale_;
    if (!(range > 0)) return {};
    return {range, v / area, w / area};
  }

 private:
  static double component(const Vec3d& p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

  // Returns a corner in sheared coordinates. Its z coordinate is the distance along the axis z_; meet() converts its
  // result to a distance along the beam.
  Vec3d sheared(const Vec3d& corner) const {
    const Vec3d p = corner - origin_;
    const double z = component(p, z_);
    return {component(p, x_) - shearX_ * z, component(p, y_) - shearY_ * z, z};
  }

  Vec3d origin_;
  int x_, y_, z_;
  double shearX_, shearY_, scale_;
};

}  // namespace scanmill
