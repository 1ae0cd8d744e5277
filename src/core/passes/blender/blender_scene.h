#pragma once

// Hands a scene to scripts/blender_passes.py.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

// An object in Blender: an instance of the scene, or a part of one whose mesh has many triangles.
struct BlenderObject {
  std::uint32_t instance = 0;  // 1 + index into Scene::instances
  std::uint32_t firstTriangle = 0;
};

// Blender writes a triangle's number as float32, which is exact for whole numbers up to this one.
constexpr std::uint32_t kBlenderTriangles = std::uint32_t{1} << 24;

// Writes scene.bin, arrays of little-endian numbers, and scene.json, which says where each array lies. Positions are
// relative to `origin`. A mesh with one instance is written in place, computed in double precision before it is rounded
// to float32; other meshes are written in their own frame, with a matrix for each instance. Returns the objects: object
// n in Blender's images is element n - 1. Throws Error.
std::vector<BlenderObject> writeBlenderScene(const Scene& scene, const Vec3d& origin, int threads,
                                             const std::filesystem::path& folder,
                                             std::uint32_t trianglesOfAnObject = kBlenderTriangles);

}  // namespace scanmill
