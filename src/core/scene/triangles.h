#pragma once

// Tests and drops triangles of a mesh, and visits triangles of given classes.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

// True if the triangle can be traced; otherwise counts the reason in `dropped`.
[[nodiscard]] bool canBeTraced(const Triangle& triangle, const std::vector<Vec3f>& positions, Dropped& dropped);

// Drops the triangles of a mesh for which keep(index) returns false. The other triangles keep their order.
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

// Returns the corners of a triangle in the mesh's frame (m).
inline std::array<Vec3d, 3> cornersOf(const Mesh& mesh, std::uint32_t triangle) {
  const auto [a, b, c] = mesh.triangles[triangle];
  return {Vec3d(mesh.positions[a]), Vec3d(mesh.positions[b]), Vec3d(mesh.positions[c])};
}

// Returns the corners of a triangle in another frame, to which `fromMesh` transforms the mesh.
inline std::array<Vec3d, 3> cornersOf(const Affine& fromMesh, const Mesh& mesh, std::uint32_t triangle) {
  const auto [a, b, c] = cornersOf(mesh, triangle);
  return {fromMesh * a, fromMesh * b, fromMesh * c};
}

// Maps two random numbers from 0 to 1 to a point of a triangle, uniformly by area (Turk, "Generating random points in
// triangles", Graphics Gems, 1990).
inline Vec3d pointInTriangle(const std::array<Vec3d, 3>& corners, double u, double v) {
  const double root = std::sqrt(u);
  return corners[0] * (1 - root) + corners[1] * (root * (1 - v)) + corners[2] * (root * v);
}

// Calls visit(instance, triangle, corners) for each triangle of `classes` in the first `instanceCount` instances,
// except moving instances. `instance`: index in Scene::instances; `triangle`: index in Mesh::triangles; `corners`: m,
// world frame.
template <class Visit>
void forEachTriangleOf(const Scene& scene, const std::vector<std::uint16_t>& classes, std::size_t instanceCount,
                       const Visit& visit) {
  for (std::uint32_t i = 0; i < instanceCount; ++i) {
    const Instance& instance = scene.instances[i];
    if (instance.moves()) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const std::uint16_t semantic = mesh.surfaces[mesh.surfaceOf[t]].semantic;
      if (std::ranges::find(classes, semantic) == classes.end()) continue;
      visit(i, t, cornersOf(instance.worldFromMesh, mesh, t));
    }
  }
}

}  // namespace scanmill
