#pragma once

// Makes of a scene the triangles that the viewer draws and picks, at their places in the world.

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

// What the triangles of a surface have in common; indices into the lists of ViewMesh.
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
  std::vector<std::uint16_t> semantic;  // of each triangle the class id
  std::vector<std::uint32_t> instance;  // of each triangle the instance id; 0 where it has none
  std::vector<std::uint32_t> surface;   // of each triangle an index into surfaces
  std::vector<ViewSurface> surfaces;
  std::vector<std::string> parts;  // "hall: Wall.003": the placed object and the asset's node
  std::vector<std::string> materials;
  std::vector<float> reflectance;     // of each material
  std::vector<std::string> textures;  // their names in the assets; the first stands for no texture
  // What gave the class: "line 12: wall (node: Wall*)", a rule of the scene's file, or "line 30: wall (of the object)".
  // The first two stand for neither: triangles without a class, and those whose object or file brings its own.
  std::vector<std::string> rules;
  Ontology ontology;
  Box bounds;                         // m, from `origin`
  Box core;                           // m, from `origin`: where the most of it is
  std::vector<std::string> warnings;  // of rules that match nothing, or decide on nothing
  bool moves = false;                 // objects of the scene move: this is how they stand at one time
  std::vector<Box> boxes;             // m, from `origin`; each holds the next kTrianglesPerBox triangles

  static constexpr std::size_t kTrianglesPerBox = 256;
  std::size_t size() const { return semantic.size(); }
  const ViewSurface& surfaceOf(std::size_t triangle) const { return surfaces[surface[triangle]]; }
};

constexpr std::uint64_t kMostViewTriangles = 30'000'000;

// Makes the mesh of a scene, the same every time, on all threads. A scene with more than kMostViewTriangles gives a
// mesh without triangles whose `problem` says so.
ViewMesh makeViewMesh(const Scene& scene);

// Reads a scene without its textures and makes its mesh, moving objects where they are at a time (s since the drive
// began). `ontology`: in place of the scene's own. Faults of the scene do not throw: `problem` names them.
ViewMesh loadViewMesh(const std::filesystem::path& file, std::uint64_t seed, double time = 0,
                      const std::filesystem::path& ontology = {});

struct MeshHit {
  std::size_t triangle = 0;
  double distance = 0;  // m
};
// The first triangle on a ray. Its origin (m) counts from mesh.origin. Absent where the ray meets no triangle.
std::optional<MeshHit> pickTriangle(const ViewMesh& mesh, const Vec3d& origin, const Vec3d& direction);

}  // namespace scanmill
