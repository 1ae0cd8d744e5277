#pragma once

// The scene as Embree traces it: float32 triangles relative to a nearby origin, together with their exact planes.

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

struct RTCDeviceTy;
struct RTCSceneTy;
struct RTCFilterFunctionNArguments;

namespace scanmill {

// The labels of hits on a triangle.
struct HitSurface {
  std::uint32_t instance = 0;
  std::uint16_t semantic = 0;
  std::uint16_t material = 0;
};

// All data of a triangle that resolving a hit reads, in one record, so that a hit reads few cache lines. The plane is
// normal . p = offset (m), computed in double from the mesh's corners; the normal is a unit vector.
struct BlockTriangle {
  Vec3d normal;
  double offset;
  std::uint32_t surface;    // index into TriangleBlock::surfaces
  std::uint32_t primitive;  // the triangle's index in its mesh
};

// Triangles in one frame. Triangles with an alpha-tested material come last and are a separate Embree geometry (id 1),
// so that only they need the alpha test; all others are geometry 0.
struct TriangleBlock {
  std::vector<Vec3f> vertices;    // one more vertex is padding, because Embree reads 16 bytes per vertex
  std::vector<Triangle> corners;  // indices of vertices; Embree reads them too
  std::vector<Vec2f> uvs;         // empty, or one per vertex
  std::vector<BlockTriangle> triangles;
  std::vector<HitSurface> surfaces;  // HitSurface::instance is the instance id (baked), or the object's number in its
                                     // mesh (instanced)
  std::uint32_t firstAlpha = 0;      // triangles with at least this index are alpha-tested

  const HitSurface& surfaceOf(std::uint32_t triangle) const { return surfaces[triangles[triangle].surface]; }
  std::uint32_t global(std::uint32_t geometry, std::uint32_t primitiveOfGeometry) const {
    return primitiveOfGeometry + (geometry == 0 ? 0 : firstAlpha);
  }
};

// A mesh placed by an Embree instance.
struct PlacedBlock {
  const TriangleBlock* block = nullptr;
  Affine originFromMesh;  // m, relative to the world's origin; for a moving mesh, at the start of the revolution
  Mat3 normalFromMesh;    // the inverse transpose of originFromMesh's linear part
  std::uint32_t firstInstanceId = 0;
  bool moves = false;
  Affine atEnd = {};  // originFromMesh of a moving mesh at the end of the revolution; interpolated linearly, as in
                      // Embree

  // Returns originFromMesh at a fraction of the revolution, 0 to 1.
  Affine at(double part) const;
};

// Deleters for Embree's reference-counted handles.
struct DeviceDeleter {
  void operator()(RTCDeviceTy* device) const;
};
struct SceneDeleter {
  void operator()(RTCSceneTy* scene) const;
};
using DeviceHandle = std::unique_ptr<RTCDeviceTy, DeviceDeleter>;
using SceneHandle = std::unique_ptr<RTCSceneTy, SceneDeleter>;

DeviceHandle makeDevice();
// Returns the version of the Embree library in use, such as "4.3.3".
std::string embreeVersion(RTCDeviceTy* device);

enum class HierarchyQuality { Low, Medium, High };
enum class Instancing { Auto, Always, Never };

// Options for building Embree's hierarchy.
struct HierarchyOptions {
  bool robust = true;  // true: watertight at edges (RTC_SCENE_FLAG_ROBUST)
  HierarchyQuality quality = HierarchyQuality::Medium;
  // Embree's filter functions: for intersections with opaque and with alpha-tested triangles, and for occlusions. Null:
  // no filter.
  void (*solidFilter)(const RTCFilterFunctionNArguments*) = nullptr;
  void (*alphaFilter)(const RTCFilterFunctionNArguments*) = nullptr;
  void (*occlusionFilter)(const RTCFilterFunctionNArguments*) = nullptr;
};

// The meshes that are instanced: built once, for all origins.
struct SharedMeshes {
  std::vector<std::unique_ptr<TriangleBlock>> blocks;  // one per mesh of the scene; null: the mesh is baked
  std::vector<SceneHandle> scenes;
};

// Returns true if objects in the worlds of a scene move. For a part of a scene, the motion of the complete scene
// (Scene::whole) decides, unless instancing is Never: then only the part decides.
bool worldsMove(const Scene& scene, Instancing instancing);

// Returns for each mesh whether it is instanced. Instancing::Auto instances the meshes that are placed more than once,
// if the scene is too large to be flattened. If something in the scene moves, all meshes are instanced, so that no
// hierarchy of triangles is rebuilt for each revolution.
std::vector<bool> instancedMeshes(const Scene& scene, Instancing instancing);

SharedMeshes buildSharedMeshes(RTCDeviceTy* device, const Scene& scene, const std::vector<bool>& instanced,
                               const HierarchyOptions& options);

// The complete scene relative to one origin and, if something moves, during one revolution. Not modified after it is
// built.
struct World {
  Vec3d origin;
  const Scene* scene = nullptr;
  TriangleBlock baked;                   // in world axes, relative to `origin`
  std::vector<PlacedBlock> placed;       // index: Embree's instance id minus kFirstPlaced
  const SharedMeshes* shared = nullptr;  // owns the blocks of `placed`; outlives the world
  SceneHandle embree;
  bool alpha = false;
  double time = 0;                                  // s, start of the revolution; used only if the scene moves
  double duration = 0;                              // s, duration of the revolution; 0: nothing moves
  static constexpr std::uint32_t kFirstPlaced = 2;  // instance ids 0 and 1 are not used, because the baked geometries
                                                    // have these numbers
};

std::unique_ptr<World> buildWorld(RTCDeviceTy* device, const Scene& scene, const Vec3d& origin,
                                  const std::vector<bool>& instanced, const SharedMeshes& shared,
                                  const HierarchyOptions& options, double time = 0, double duration = 0);

// Returns true if the alpha-tested material of a triangle is transparent at these barycentric coordinates.
bool transparentAt(const World& world, const TriangleBlock& block, std::uint32_t triangle, double u, double v);

}  // namespace scanmill
