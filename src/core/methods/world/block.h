#pragma once

// Blocks: triangles as Embree traces them, together with their exact planes.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

struct RTCDeviceTy;
struct RTCSceneTy;
struct RTCFilterFunctionNArguments;

namespace scanmill {

// The labels of hits on a triangle.
struct HitSurface {
  std::uint32_t instance = 0;  // instance id, or the object's number: see TriangleBlock::surfaces
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
// so that only this geometry needs the alpha test; all other triangles are geometry 0.
struct TriangleBlock {
  std::vector<Vec3f> vertices;    // one more vertex is padding, because Embree reads 16 bytes per vertex
  std::vector<Triangle> corners;  // indices of vertices; Embree reads them too
  std::vector<Vec2f> uvs;         // empty, or one per vertex
  std::vector<BlockTriangle> triangles;
  std::vector<HitSurface> surfaces;  // HitSurface::instance is the instance id (baked), or the object's number in its
                                     // mesh (instanced)
  std::uint32_t firstAlpha = 0;      // triangles with at least this index are alpha-tested

  const HitSurface& surfaceOf(std::uint32_t triangle) const { return surfaces[triangles[triangle].surface]; }
  // Returns a triangle's index in `triangles` from Embree's ids of the geometry and of the triangle in the geometry.
  std::uint32_t indexOf(std::uint32_t geometry, std::uint32_t primitiveOfGeometry) const {
    return primitiveOfGeometry + (geometry == 0 ? 0 : firstAlpha);
  }
};

// Embree's objects, which are released when their last owner is destroyed.
using DeviceHandle = std::shared_ptr<RTCDeviceTy>;
using SceneHandle = std::shared_ptr<RTCSceneTy>;

DeviceHandle makeDevice();
// Returns the version of the Embree library in use, such as "4.3.3".
std::string embreeVersion(RTCDeviceTy* device);

// Filter functions for Embree: for hits on opaque triangles, on alpha-tested triangles, and for occlusions. Null: none.
struct HierarchyOptions {
  void (*solidFilter)(const RTCFilterFunctionNArguments*) = nullptr;
  void (*alphaFilter)(const RTCFilterFunctionNArguments*) = nullptr;
  void (*occlusionFilter)(const RTCFilterFunctionNArguments*) = nullptr;
};

// A mesh to be added to a block.
struct BlockSource {
  const Mesh* mesh;
  Affine blockFromMesh;
  std::uint32_t firstVertex, firstSurface;  // indices in the block of the mesh's first vertex and surface
};

// Fills an empty block, whose surfaces are set, with the triangles of meshes. `scene` has the meshes' materials.
void fillBlock(TriangleBlock& block, const Scene& scene, const std::vector<BlockSource>& sources);

// Returns the block of a mesh in the mesh's own axes. Each HitSurface::instance is the object's number in the mesh.
std::unique_ptr<TriangleBlock> blockOf(const Scene& scene, const Mesh& mesh);

SceneHandle newScene(RTCDeviceTy* device);  // watertight at the edges of triangles
// Adds a block's triangles to an Embree scene as geometries 0 and 1. The block must outlive the scene, which reads it.
void attachBlock(RTCDeviceTy* device, RTCSceneTy* scene, const TriangleBlock& block, const HierarchyOptions& options);
// Throws Error if Embree has failed on this thread: "Embree could not `what`".
void checkEmbree(RTCDeviceTy* device, const char* what);

}  // namespace scanmill
