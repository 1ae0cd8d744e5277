#pragma once

// A scene's triangles as they are uploaded to the graphics card: each mesh once, in chunks of neighbouring triangles.

#include <cstdint>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace scanmill {

// Consecutive triangles of a batch, all of one mesh, and their bounds (m, mesh axes, relative to ViewMesh::origin).
struct ViewChunk {
  std::uint32_t firstTriangle = 0;  // index in the chunk's batch
  std::uint32_t triangles = 0;
  Vec3f low;
  Vec3f high;
};

// Triangles without shared vertices: three corners per triangle. Large triangles are split into several.
struct ViewBatch {
  std::vector<float> positions;         // 3 per corner: m, mesh axes, relative to ViewMesh::origin
  std::vector<float> uvs;               // 2 per corner; empty for solid triangles
  std::vector<std::uint32_t> cutouts;   // 1 per corner: index into ViewGeometry::cutouts; empty for solid triangles
  std::vector<std::uint32_t> original;  // per triangle: index into Mesh::triangles
  std::vector<ViewChunk> chunks;
};

struct ChunkRange {
  std::uint32_t first = 0;
  std::uint32_t end = 0;
};

struct ViewMesh {
  Vec3d origin;  // m, mesh axes; float32 represents origin, and position - origin, exactly
  Vec3f low;     // m, bounds of all chunks, relative to `origin`
  Vec3f high;
  ChunkRange solid;
  ChunkRange cut;  // triangles with an alpha-tested material
};

// The transparent texels of a texture: one bit per texel, set if the texel is transparent. Texel (column, row) is bit
// 32 * firstWord + row * width + column; row 0 is at v = 0. Shaders read this record as four unsigned integers.
struct ViewCutout {
  std::uint32_t firstWord;
  std::uint32_t width;
  std::uint32_t height;
  std::uint32_t unused;
};

struct ViewGeometry {
  ViewBatch solid;
  ViewBatch cut;
  std::vector<ViewMesh> meshes;  // in the order of Scene::meshes; meshes without an instance are empty
  std::vector<ViewCutout> cutouts;
  std::vector<std::uint32_t> cutoutWords;  // bits of all cut-outs
};

// Converts a scene. Throws Error if a batch gets more than `trianglesPerBatch` triangles.
ViewGeometry buildViewGeometry(const Scene& scene, std::uint64_t trianglesPerBatch);

}  // namespace scanmill
