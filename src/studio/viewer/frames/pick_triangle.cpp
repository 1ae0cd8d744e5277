// Finds the nearest triangle of a mesh that a ray hits.

#include <algorithm>
#include <limits>

#include "viewer/frames/view_mesh.h"

namespace scanmill {

namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
// Length (m) by which boxes are enlarged, so that rounding errors cannot cause rays to miss flat boxes.
constexpr double kBoxSlack = 1e-6;

// Returns the distance (m) at which a ray enters a box; 0 if it starts inside; infinity if it misses. Slab method of T.
// Kay and J. Kajiya, "Ray tracing complex scenes", SIGGRAPH 1986.
double entry(const Box& box, const Vec3d& origin, const Vec3d& direction) {
  double enter = 0;
  double leave = kNever;
  const auto clip = [&](double low, double high, double from, double along) {
    low -= kBoxSlack;
    high += kBoxSlack;
    if (along == 0) {
      if (from < low || from > high) leave = -kNever;
      return;
    }
    const double a = (low - from) / along;
    const double b = (high - from) / along;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  };
  clip(box.low.x, box.high.x, origin.x, direction.x);
  clip(box.low.y, box.high.y, origin.y, direction.y);
  clip(box.low.z, box.high.z, origin.z, direction.z);
  return enter <= leave ? enter : kNever;
}

// Returns the distance (m) at which a ray hits a triangle from either side; infinity if it misses. T. Moeller and B.
// Trumbore, "Fast, minimum storage ray-triangle intersection", 1997.
double distanceTo(const Vec3f* corners, const Vec3d& origin, const Vec3d& direction) {
  const Vec3d a(corners[0]);
  const Vec3d ab = Vec3d(corners[1]) - a;
  const Vec3d ac = Vec3d(corners[2]) - a;
  const Vec3d p = cross(direction, ac);
  const double det = dot(ab, p);
  if (det == 0) return kNever;
  const Vec3d fromA = origin - a;
  const double u = dot(fromA, p) / det;
  if (!(u >= 0 && u <= 1)) return kNever;
  const Vec3d q = cross(fromA, ab);
  const double v = dot(direction, q) / det;
  if (!(v >= 0 && u + v <= 1)) return kNever;
  const double t = dot(ac, q) / det;
  return t >= 0 ? t : kNever;
}

}  // namespace

std::optional<MeshHit> pickTriangle(const ViewMesh& mesh, const Vec3d& origin, const Vec3d& direction) {
  const Vec3d along = normalized(direction);
  if (!isFinite(origin) || !isFinite(along) || along == Vec3d{}) return std::nullopt;
  MeshHit best{0, kNever};
  for (std::size_t b = 0; b < mesh.boxes.size(); ++b) {
    if (!(entry(mesh.boxes[b], origin, along) < best.distance)) continue;
    const std::size_t first = b * ViewMesh::kTrianglesPerBox;
    const std::size_t last = std::min(first + ViewMesh::kTrianglesPerBox, mesh.size());
    for (std::size_t t = first; t < last; ++t) {
      const double distance = distanceTo(&mesh.corners[3 * t], origin, along);
      if (distance < best.distance) best = {t, distance};
    }
  }
  if (best.distance == kNever) return std::nullopt;
  return best;
}

}  // namespace scanmill
