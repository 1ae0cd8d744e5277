#pragma once

// The scene as Embree traces it: float32 triangles relative to a nearby origin, together with their exact planes.

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "base/vec.h"
#include "methods/world/block.h"
#include "methods/world/shared_meshes.h"
#include "scene/placements.h"
#include "scene/scene.h"

namespace scanmill {

// A mesh, or a part of a mesh, placed by an Embree instance.
struct PlacedBlock {
  const TriangleBlock* block = nullptr;
  Affine originFromMesh;  // m, relative to the world's origin; for a moving mesh, at the start of the revolution
  Mat3 normalFromMesh;    // the inverse transpose of originFromMesh's linear part
  std::uint32_t firstInstanceId = 0;
  std::uint32_t instance = 0;  // index into Scene::instances
  bool moves = false;
  Affine atEnd = {};  // originFromMesh of a moving mesh at the end of the revolution; interpolated linearly, as in
                      // Embree
  RTCSceneTy* hierarchy = nullptr;  // of the block, in the mesh's axes

  // Returns originFromMesh at a fraction of the revolution, 0 to 1.
  Affine at(double fraction) const;
};

enum class Instancing { Auto, Always, Never };

// Returns true if objects in the worlds of a scene move. For a part of a scene, the motion of the complete scene
// (Scene::unreduced) decides, unless instancing is Never: then only the part decides.
bool worldsMove(const Scene& scene, Instancing instancing);

// Returns for each mesh whether it is instanced. If something in the scene moves, all meshes are instanced, so that no
// hierarchy of triangles is rebuilt for each revolution. Otherwise Instancing::Auto instances the meshes that are
// placed more than once, if the scene is too large to be flattened.
std::vector<bool> instancedMeshes(const Scene& scene, Instancing instancing);

// A revolution's time, and the reach of its rays. Both values matter only if something in the scene moves: see Worlds.
struct Revolution {
  double time = 0;      // s, start of the revolution
  double duration = 0;  // s; 0: nothing moves
  // Distance (m) from the world's origin beyond which instanced meshes may be left out, because no ray gets there.
  double reach = std::numeric_limits<double>::infinity();
  std::shared_ptr<const Placements> placed = nullptr;  // see Shot::placed
};

// The scene relative to one origin and, if something moves, during one revolution. Not modified after it is built.
struct World {
  Vec3d origin;
  const Scene* scene = nullptr;
  TriangleBlock baked;              // in world axes, relative to `origin`
  std::vector<PlacedBlock> placed;  // index: Embree's instance id minus kFirstPlaced
  SceneHandle embree;
  Revolution revolution;
  static constexpr std::uint32_t kFirstPlaced = 2;  // instance ids 0 and 1 are not used, because the baked geometries
                                                    // have these numbers
};

// Builds the world of a scene around `origin` (m). `instanced`: the result of instancedMeshes(). `shared`: the meshes
// that are instanced. The scene and `shared` must outlive the world.
std::unique_ptr<World> buildWorld(RTCDeviceTy* device, const Scene& scene, const Vec3d& origin,
                                  const std::vector<bool>& instanced, const SharedMeshes& shared,
                                  const HierarchyOptions& options, const Revolution& revolution = {});

// Returns true if the alpha-tested material of a triangle is transparent at these barycentric coordinates.
bool transparentAt(const World& world, const TriangleBlock& block, std::uint32_t triangle, double u, double v);

}  // namespace scanmill
