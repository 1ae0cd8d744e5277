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

// Blender writes a triangle's number as float32, which holds whole numbers up to here.
constexpr std::uint32_t kBlenderTriangles = std::uint32_t{1} << 24;

// Writes scene.json and scene.bin: arrays of numbers, little-endian, and where they lie. All is relative to `origin`,
// and meshes that are placed once are moved there in double precision, so that float32 loses nothing near it. Returns
// the objects in the order of their numbers in Blender's images, which count from 1. Throws Error.
std::vector<BlenderObject> writeBlenderScene(const Scene& scene, const Vec3d& origin, int threads,
                                             const std::filesystem::path& folder,
                                             std::uint32_t trianglesOfAnObject = kBlenderTriangles);

}  // namespace scanmill
