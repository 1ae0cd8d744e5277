#pragma once

// Converts a scene to the triangles that the viewer draws and picks, in world coordinates.

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

// Properties that the triangles of a surface share, as indices into the lists of ViewMesh.
struct ViewSurface {
  std::uint32_t part = 0;
  std::uint32_t material = 0;
  std::uint32_t texture = 0;
  std::uint32_t rule = 0;
  bool operator==(const ViewSurface&) const = default;
};

struct ViewMesh {
  std::string name;
  // Why there is no mesh: the scene could not be read, or is too large. Then everything else is empty.
  std::string problem;
  Vec3d origin;                         // m, world; the corners count from here
  std::vector<Vec3f> corners;           // m, along the world's axes; three for each triangle
  std::vector<std::uint16_t> semantic;  // class id of each triangle
  std::vector<std::uint32_t> instance;  // instance id of each triangle; 0: none
  std::vector<std::uint32_t> surface;   // index of each triangle into `surfaces`
  std::vector<ViewSurface> surfaces;
  std::vector<std::string> parts;  // "hall: Wall.003": the placed object and the asset's node
  std::vector<std::string> materials;
  std::vector<float> reflectance;     // reflectance of each material
  std::vector<std::string> textures;  // their names in the assets; the first stands for no texture
  // The sources of the classes: "line 12: wall (node: Wall*)", a rule of the scene's file, or "line 30: wall (of the
  // object)". The first two entries are neither: triangles without a class, and those whose object or file has its own.
  std::vector<std::string> rules;
  Ontology ontology;
  Box bounds;                         // m, from `origin`
  Box core;                           // m, from `origin`: holds most of the mesh
  std::vector<std::string> warnings;  // about rules without effect and files with one instance, see ruleWarnings()
  bool moves = false;                 // objects of the scene move: the mesh shows them at one time
  std::vector<Box> boxes;             // m, from `origin`; each holds the next kTrianglesPerBox triangles

  static constexpr std::size_t kTrianglesPerBox = 256;
  std::size_t size() const { return semantic.size(); }
  const ViewSurface& surfaceOf(std::size_t triangle) const { return surfaces[surface[triangle]]; }
};

constexpr std::uint64_t kMostViewTriangles = 30'000'000;

// Builds the mesh of a scene on all threads; the result is deterministic. A scene with more than kMostViewTriangles
// gives a mesh without triangles whose `problem` says so.
ViewMesh makeViewMesh(const Scene& scene);

// Reads a scene without its textures and builds its mesh, with moving objects where they are at `time` (s since the
// drive began). `ontology`: replaces the scene's own. Faults of the scene do not throw: `problem` names them.
ViewMesh loadViewMesh(const std::filesystem::path& file, std::uint64_t seed, double time = 0,
                      const std::filesystem::path& ontology = {});

struct MeshHit {
  std::size_t triangle = 0;
  double distance = 0;  // m
};
// Returns the first triangle that a ray hits. `origin` (m) counts from mesh.origin. Absent if the ray hits no triangle.
std::optional<MeshHit> pickTriangle(const ViewMesh& mesh, const Vec3d& origin, const Vec3d& direction);

}  // namespace scanmill
