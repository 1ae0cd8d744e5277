#pragma once

// Converts a scene to the triangles that the viewer draws and selects: relative to ViewMesh::origin, in world axes.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scene/ontology.h"
#include "scene/scene.h"
#include "viewer/frames/frame_source.h"

namespace scanmill {

// Properties of a surface's triangles: indices in ViewMesh::parts, materials, textures and rules.
struct ViewSurface {
  std::uint32_t part = 0, material = 0, texture = 0, rule = 0;
  bool operator==(const ViewSurface&) const = default;
};

struct ViewMesh {
  // Why there is no mesh (scene unreadable or too large); all other members are then empty.
  std::string problem;
  Vec3d origin;                         // origin of all coordinates of this mesh, in the world frame (m)
  std::vector<Vec3f> corners;           // three per triangle, relative to `origin`, along the world's axes (m)
  std::vector<std::uint16_t> semantic;  // class id of each triangle
  std::vector<std::uint32_t> instance;  // instance id of each triangle; 0: no instance
  std::vector<std::uint32_t> surface;   // index in `surfaces` for each triangle
  std::vector<ViewSurface> surfaces;
  // Names of parts, such as "hall: Wall.003": the object in the scene and the node in its asset.
  std::vector<std::string> parts;
  std::vector<std::string> materials;
  std::vector<float> reflectance;     // one per material, 0 to 1
  std::vector<std::string> textures;  // names of textures in the assets; the first entry means no texture
  // The sources of classes: a rule in the scene file, such as "line 12: wall (node: Wall*)", or the object, such as
  // "line 30: wall (of the object)". The first two entries are special: triangles without a class, and triangles whose
  // object or file defines their class.
  std::vector<std::string> rules;
  Ontology ontology;
  Box bounds;                         // bounding box, relative to `origin` (m)
  Box core;                           // box that contains most of the parts, relative to `origin` (m)
  std::vector<Box> partBoxes;         // bounding box of each part, relative to `origin` (m)
  std::vector<std::string> warnings;  // result of ruleWarnings(), about rules without effect
  bool moves = false;                 // true: the scene has moving objects, and the mesh shows them at one time
  std::vector<Box> boxes;  // bounding boxes of kTrianglesPerBox consecutive triangles, relative to `origin` (m)

  static constexpr std::size_t kTrianglesPerBox = 256;
  std::size_t size() const { return semantic.size(); }
  const ViewSurface& surfaceOf(std::size_t triangle) const { return surfaces[surface[triangle]]; }
};

constexpr std::uint64_t kMostViewTriangles = 30'000'000;

// Builds the mesh of a scene. Uses all threads; the result does not depend on the number of threads. If the scene has
// more than kMostViewTriangles triangles, returns a mesh without triangles whose `problem` states this.
ViewMesh makeViewMesh(const Scene& scene);

// Reads a scene without its textures and builds its mesh. If the scene cannot be read, does not throw but sets
// `problem`.
ViewMesh loadViewMesh(const SceneChoice& choice);

struct MeshHit {
  std::size_t triangle = 0;
  double distance = 0;  // distance from the ray's origin (m)
};
// Returns the nearest triangle that a ray hits; nothing if it hits none, or if the ray is not finite. `origin`:
// relative to mesh.origin (m). `direction`: need not have unit length.
std::optional<MeshHit> pickTriangle(const ViewMesh& mesh, const Vec3d& origin, const Vec3d& direction);

}  // namespace scanmill
