#pragma once

// Writes a scene for scripts/blender_passes.py.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

// An object in Blender: an instance of the scene or, if its mesh has very many triangles, a part of an instance.
struct BlenderObject {
  std::uint32_t instance = 0;  // 1 + index into Scene::instances
  std::uint32_t firstTriangle = 0;
};

// Largest number of triangles of an object. Blender writes triangle numbers as float32, exact up to this number.
constexpr std::uint32_t kBlenderTriangles = std::uint32_t{1} << 24;

// Writes scene.bin, arrays of little-endian numbers, and scene.json, which has the offset of each array in scene.bin.
// Positions are relative to `origin`. If a mesh has one instance, its vertices are transformed in double precision and
// then rounded to float32; a mesh with several instances is written in the mesh's frame, with a matrix for each
// instance. Returns the objects: object n in Blender's images is element n - 1. Throws Error.
std::vector<BlenderObject> writeBlenderScene(const Scene& scene, const Vec3d& origin, int threads,
                                             const std::filesystem::path& folder,
                                             std::uint32_t trianglesOfAnObject = kBlenderTriangles);

}  // namespace scanmill
