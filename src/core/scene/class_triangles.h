#pragma once

// The triangles of certain classes, where they stand in the world.

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "scene/scene.h"

namespace scanmill {

// Calls use(instance, triangle, corners) for each, with the index of the instance and that of the triangle in its mesh,
// and the corners in the world's frame (m). What moves is left out, and so are instances from `before` on.
template <class Use>
void forEachTriangleOf(const Scene& scene, const std::vector<std::uint16_t>& classes, std::size_t before,
                       const Use& use) {
  for (std::uint32_t i = 0; i < before; ++i) {
    const Instance& instance = scene.instances[i];
    if (instance.moves()) continue;
    const Mesh& mesh = scene.meshes[instance.mesh];
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const std::uint16_t semantic = mesh.surfaces[mesh.surfaceOf[t]].semantic;
      if (std::find(classes.begin(), classes.end(), semantic) == classes.end()) continue;
      std::array<Vec3d, 3> corners;
      for (std::size_t k = 0; k < 3; ++k) {
        corners[k] = instance.worldFromMesh * Vec3d(mesh.positions[mesh.triangles[t][k]]);
      }
      use(i, t, corners);
    }
  }
}

}  // namespace scanmill
