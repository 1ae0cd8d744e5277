#pragma once

// A scene's triangles, placed, as the viewer draws and picks them.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scene/ontology.h"
#include "scene/scene.h"

namespace scanmill {

struct ViewMesh {
  std::string name;
  std::string problem;         // why there is no mesh: the scene could not be read, or is too large; then all is empty
  Vec3d origin;                // m, world: what the corners count from
  std::vector<Vec3f> corners;  // three a triangle, world axes, m
  std::vector<std::uint16_t> semantic;  // per triangle: class id
  std::vector<std::uint32_t> instance;  // 0: none
  std::vector<std::uint16_t> material;  // index into materials
  std::vector<std::uint32_t> part;      // index into parts
  std::vector<std::string> materials;
  std::vector<std::string> parts;  // "hall: Wall.003": the placed object and the asset's node
  std::vector<float> reflectance;  // per material
  Ontology ontology;
  Box bounds;              // m, from `origin`
  Box core;                // where most of it is: the middle 90 % of the corners along each axis
  std::vector<Box> boxes;  // of each kTrianglesPerBox triangles, in order, from `origin`

  static constexpr std::size_t kTrianglesPerBox = 256;
  std::size_t size() const { return semantic.size(); }
};

constexpr std::uint64_t kMostViewTriangles = 20'000'000;

// Deterministic; uses all threads. A scene of more triangles gives a mesh without them whose `problem` says so.
ViewMesh makeViewMesh(const Scene& scene);

// Reads the scene (without textures) and makes its mesh. Never throws for what is wrong with the scene: see `problem`.
ViewMesh loadViewMesh(const std::filesystem::path& file, std::uint64_t seed);

// The first triangle on a ray (origin counted from mesh.origin), and how far it is (m).
struct MeshHit {
  std::size_t triangle = 0;
  double distance = 0;
};
std::optional<MeshHit> pickTriangle(const ViewMesh& mesh, const Vec3d& origin, const Vec3d& direction);

}  // namespace scanmill
