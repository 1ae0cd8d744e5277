#pragma once

// Tests whether triangles can be traced, and drops triangles of a mesh.

#include <cstddef>
#include <vector>

#include "scene/scene.h"

namespace scanmill {

// True if the triangle can be traced; otherwise counts the reason in `dropped`.
[[nodiscard]] bool canBeTraced(const Triangle& triangle, const std::vector<Vec3f>& positions, Dropped& dropped);

// Drops the triangles of a mesh for which `keep`, called with their indices, returns false. The remaining triangles
// keep their order.
template <class Keep>
void keepTriangles(Mesh& mesh, const Keep& keep) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!keep(t)) continue;
    mesh.triangles[kept] = mesh.triangles[t];
    mesh.surfaceOf[kept] = mesh.surfaceOf[t];
    ++kept;
  }
  mesh.triangles.resize(kept);
  mesh.surfaceOf.resize(kept);
}

}  // namespace scanmill
