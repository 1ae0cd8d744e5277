#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "scene/scene.h"
#include "scene/triangles.h"

namespace scanmill {
namespace {

// Limit of the ratio of twice a triangle's area to the product of two sides. Below this limit, the corners are
// collinear as far as double arithmetic on float32 coordinates can tell. The ratio of the thinnest triangle that
// float32 can represent is far above the limit.
constexpr double kCollinear = 1e-14;

bool isDegenerate(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d ab = b - a;
  const Vec3d ac = c - a;
  const Vec3d normal = cross(ab, ac);
  // Squares decide nearly all triangles without square roots. The factor exceeds the rounding errors.
  constexpr double kRounding = 1.001;
  if (dot(normal, normal) > kRounding * kCollinear * kCollinear * dot(ab, ab) * dot(ac, ac)) return false;
  return !(length(normal) > kCollinear * length(ab) * length(ac));
}

}  // namespace

Dropped& Dropped::operator+=(const Dropped& o) {
  nonFinite += o.nonFinite;
  degenerate += o.degenerate;
  outOfRange += o.outOfRange;
  return *this;
}

// Ignores vertices that no triangle uses, since clean() leaves zeroed vertices behind. For speed, loads four floats at
// each vertex, of which the fourth is the next vertex's and is ignored, except at the last vertex; and keeps bounds for
// the first, the second and the third corners, so that the processor works on the three side by side.
Box Mesh::bounds() const {
  typedef float Floats __attribute__((vector_size(16)));
  if (triangles.empty()) return {};
  const std::size_t last = positions.size() - 1;
  const auto load = [&](std::uint32_t vertex) {
    const Vec3f& position = positions[vertex];
    if (vertex == last) return Floats{position.x, position.y, position.z, 0};
    Floats floats;
    std::memcpy(&floats, &position, sizeof floats);
    return floats;
  };
  std::array<Floats, 3> low;  // by corner of the triangles
  low.fill(Floats{INFINITY, INFINITY, INFINITY, INFINITY});
  std::array<Floats, 3> high;
  high.fill(-low[0]);
  for (const Triangle& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Floats p = load(t[k]);
      low[k] = p < low[k] ? p : low[k];
      high[k] = p > high[k] ? p : high[k];
    }
  }
  Box box;
  for (std::size_t k = 0; k < 3; ++k) {
    box.add(Vec3d{low[k][0], low[k][1], low[k][2]});
    box.add(Vec3d{high[k][0], high[k][1], high[k][2]});
  }
  return box;
}

bool canBeTraced(const Triangle& triangle, const std::vector<Vec3f>& positions, Dropped& dropped) {
  if (std::ranges::any_of(triangle, [&](std::uint32_t corner) { return corner >= positions.size(); })) {
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
