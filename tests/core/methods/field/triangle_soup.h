#pragma once

// Scenes of loose triangles, and fields of them.

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/random.h"
#include "methods/field/distance_field.h"
#include "methods/particle/options.h"
#include "methods/world/world.h"
#include "tests/core/methods/field/same_field.h"
#include "tests/support/test_scene.h"

namespace scanmill {

// Triangles as they are, with nothing cleaned: each third of them is of an instance of its own, whose ids fall as the
// triangles' indices rise.
inline Scene sceneOf(const std::vector<std::array<Vec3f, 3>>& triangles, const Vec3d& place = {}) {
  Scene scene;
  scene.materials.resize(1);
  Mesh mesh;
  for (std::uint32_t object = 1; object <= 3; ++object) mesh.surfaces.push_back({0, 1, 4 - object, "", "", {}});
  mesh.objects = 3;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (const Vec3f& corner : triangles[t]) mesh.positions.push_back(corner);
    mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    mesh.surfaceOf.push_back(static_cast<std::uint16_t>(3 * t / triangles.size()));
  }
  scene.meshes.push_back(std::move(mesh));
  scene.instances.push_back({0, at(place.x, place.y, place.z), 1, "soup"});
  return scene;
}

inline std::unique_ptr<World> worldOf(const Scene& scene, const Vec3d& origin = {}) {
  const DeviceHandle device = makeDevice();
  const std::vector<bool> instanced(scene.meshes.size(), false);
  const SharedMeshes shared(device.get(), scene, instanced, {});
  return buildWorld(device.get(), scene, origin, instanced, shared, {});
}

inline Vec3d randomPoint(std::uint32_t i, std::uint32_t j) {
  const RandomBlock r = randomBlock({.seed = 9, .frame = j, .beam = i});
  return {2 * uniform(r[0]) - 1, 2 * uniform(r[1]) - 1, 2 * uniform(r[2]) - 1};
}

// Of sizes from `least` to `most`, spread over a cube of +-`spread`.
inline std::vector<std::array<Vec3f, 3>> soup(std::uint32_t count, double spread, double least, double most) {
  std::vector<std::array<Vec3f, 3>> triangles;
  for (std::uint32_t t = 0; t < count; ++t) {
    const Vec3d middle = randomPoint(t, 0) * spread;
    const double size = least * std::pow(most / least, (randomPoint(t, 1).x + 1) / 2);
    const auto corner = [&](std::uint32_t j) { return Vec3f(middle + randomPoint(t, j) * size); };
    triangles.push_back({corner(2), corner(3), corner(4)});
  }
  return triangles;
}

inline std::vector<std::uint32_t> listAt(const DistanceField& field, std::uint32_t word) {
  std::vector<std::uint32_t> list;
  do {
    list.push_back(field.lists[word] & ~kLastOfList);
  } while (field.lists[word++] < kLastOfList);
  return list;
}

inline FieldShape shapeAt(const Vec3d& sensor, double voxel, std::uint32_t voxels, std::uint32_t levels, bool lists) {
  ParticleOptions options;
  options.voxel = voxel;
  options.voxels = voxels;
  options.levels = levels;
  options.refine = lists ? ParticleOptions::Refine::ByTriangle : ParticleOptions::Refine::None;
  return shapeOf(options, sensor, Box{}, 100);
}

inline std::size_t fullBricks(const DistanceField& field) {
  return static_cast<std::size_t>(
      std::count_if(field.table.begin(), field.table.end(), [](std::uint32_t entry) { return entry >= kFullBrick; }));
}

}  // namespace scanmill
