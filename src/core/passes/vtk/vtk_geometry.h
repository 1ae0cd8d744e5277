#pragma once

// A scene's triangles as a graphics card draws them: each mesh once, in chunks of triangles that are close together.

#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "passes/vtk/vtk_interface.h"
#include "scene/scene.h"

namespace scanmill {

// A run of triangles of one mesh, and their bounds (m, mesh axes, relative to ViewMesh::origin).
struct ViewChunk {
  std::uint32_t firstTriangle = 0;  // in its batch
  std::uint32_t triangles = 0;
  Vec3f low;
  Vec3f high;
};

// Triangles as lists of corners, three per triangle. Large triangles are split into pieces.
struct ViewBatch {
  std::vector<float> positions;         // 3 per corner: m, mesh axes, relative to ViewMesh::origin
  std::vector<float> uvs;               // 2 per corner; empty for solid triangles
  std::vector<std::uint32_t> cutouts;   // 1 per corner; likewise
  std::vector<std::uint32_t> original;  // per triangle: index into Mesh::triangles
  std::vector<ViewChunk> chunks;
};

struct ChunkRange {
  std::uint32_t first = 0;
  std::uint32_t end = 0;
};

struct ViewMesh {
  Vec3d origin;  // m, mesh axes: exact in float32, as is every position minus the origin
  Vec3f low;     // lowest corner of all chunks
  Vec3f high;
  ChunkRange solid;
  ChunkRange cut;  // triangles with an alpha-tested material
};

struct ViewGeometry {
  ViewBatch solid;
  ViewBatch cut;
  std::vector<ViewMesh> meshes;  // as Scene::meshes; meshes without an instance are empty
  std::vector<VtkCutout> cutouts;
  std::vector<std::uint32_t> cutoutWords;
};

// Throws Error if a batch holds more than `trianglesPerBatch`.
ViewGeometry buildViewGeometry(const Scene& scene, std::uint64_t trianglesPerBatch);

}  // namespace scanmill
