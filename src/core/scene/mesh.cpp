#include <algorithm>
#include <array>
#include <cmath>

#include "scene/scene.h"
#include "scene/triangle_faults.h"

namespace scanmill {
namespace {

// Limit of the ratio of twice a triangle's area to the product of two sides. Below this limit, the corners are
// collinear as far as double arithmetic on float32 coordinates can tell. The ratio of the thinnest triangle that
// float32 can represent is far above the limit.
constexpr double kCollinear = 1e-14;

bool isDegenerate(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d u = b - a;
  const Vec3d v = c - a;
  const Vec3d normal = cross(u, v);
  // Squares decide nearly all triangles without square roots. The factor exceeds the rounding errors.
  if (dot(normal, normal) > 1.001 * kCollinear * kCollinear * dot(u, u) * dot(v, v)) return false;
  return !(length(normal) > kCollinear * length(u) * length(v));
}

}  // namespace

Dropped& Dropped::operator+=(const Dropped& o) {
  nonFinite += o.nonFinite;
  degenerate += o.degenerate;
  outOfRange += o.outOfRange;
  return *this;
}

// Ignores vertices that no triangle uses, since clean() leaves zeroed vertices behind.
Box Mesh::bounds() const {
  std::array<Vec3f, 3> low, high;  // one of each for each corner, so that the processor works on them side by side
  low.fill({INFINITY, INFINITY, INFINITY});
  high.fill({-INFINITY, -INFINITY, -INFINITY});
  for (const Triangle& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3f p = positions[t[k]];
      low[k] = {std::min(low[k].x, p.x), std::min(low[k].y, p.y), std::min(low[k].z, p.z)};
      high[k] = {std::max(high[k].x, p.x), std::max(high[k].y, p.y), std::max(high[k].z, p.z)};
    }
  }
  Box box;
  if (triangles.empty()) return box;
  for (const Vec3f& p : low) box.add(Vec3d(p));
  for (const Vec3f& p : high) box.add(Vec3d(p));
  return box;
}

bool canBeTraced(const Triangle& triangle, const std::vector<Vec3f>& positions, Dropped& dropped) {
  if (std::any_of(triangle.begin(), triangle.end(), [&](std::uint32_t corner) { return corner >= positions.size(); })) {
    ++dropped.outOfRange;
    return false;
  }
  const Vec3f& a = positions[triangle[0]];
  const Vec3f& b = positions[triangle[1]];
  const Vec3f& c = positions[triangle[2]];
  if (!isFinite(a) || !isFinite(b) || !isFinite(c)) {
    ++dropped.nonFinite;
    return false;
  }
  if (isDegenerate(Vec3d(a), Vec3d(b), Vec3d(c))) {
    ++dropped.degenerate;
    return false;
  }
  return true;
}

Dropped clean(Mesh& mesh) {
  Dropped dropped;
  keepTriangles(mesh, [&](std::size_t t) { return canBeTraced(mesh.triangles[t], mesh.positions, dropped); });
  for (Vec3f& p : mesh.positions) {
    if (!isFinite(p)) p = {};
  }
  return dropped;
}

}  // namespace scanmill
