// simplified(): reduces the number of triangles of meshes.

#include <meshoptimizer.h>

#include <cmath>
#include <numeric>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "scene/scene.h"

namespace scanmill {

namespace {

// Meshes with at most this many triangles are not simplified.
constexpr std::size_t kFewTriangles = 32;

// Allowed error in units of the mesh's extent: so large that the error never ends the simplification.
constexpr float kUnlimitedError = 1e6f;

// Corners of triangles become one vertex if their Welds have the same bytes. Corners in different surfaces therefore
// stay separate, and every triangle keeps its surface. The seam between two surfaces still stays closed, since
// meshoptimizer moves vertices at equal positions together.
struct Weld {
  Vec3f position;
  Vec2f uv;  // zero if the surface has no texture
  std::uint32_t surface = 0;
};
static_assert(sizeof(Weld) == 24, "bytes between the members would be compared, too");

// Triangles with merged vertices.
struct Welded {
  std::vector<Weld> vertices;
  std::vector<std::uint32_t> vertexOf;  // for each of `vertices`: index in the mesh of a vertex merged into it
  std::vector<std::uint32_t> corners;   // indices into `vertices`, three per triangle
};

// Returns the triangles with these indices; vertices with equal Welds are merged.
Welded weld(const Scene& scene, const Mesh& mesh, const std::vector<std::uint32_t>& triangles) {
  std::vector<bool> hasTexture(mesh.surfaces.size());
  for (std::size_t s = 0; s < hasTexture.size(); ++s) {
    hasTexture[s] = !mesh.uvs.empty() && scene.materials[mesh.surfaces[s].material].texture != nullptr;
  }
  std::vector<Weld> corners;  // one per corner
  corners.reserve(triangles.size() * 3);
  for (const std::uint32_t t : triangles) {
    const std::uint16_t surface = mesh.surfaceOf[t];
    for (const std::uint32_t vertex : mesh.triangles[t]) {
      // Adding zero replaces minus zero by zero: equal positions must have equal bytes.
      corners.push_back({mesh.positions[vertex] + Vec3f{}, hasTexture[surface] ? mesh.uvs[vertex] : Vec2f{}, surface});
    }
  }
  Welded welded;
  welded.corners.resize(corners.size());
  const std::size_t count = meshopt_generateVertexRemap(welded.corners.data(), nullptr, corners.size(), corners.data(),
                                                        corners.size(), sizeof(Weld));
  welded.vertices.resize(count);
  welded.vertexOf.resize(count);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    welded.vertices[welded.corners[i]] = corners[i];
    welded.vertexOf[welded.corners[i]] = mesh.triangles[triangles[i / 3]][i % 3];
  }
  return welded;
}

// Simplifies the triangles of `source` with these indices to about the fraction `keep`, and appends the result to
// `target`. The new triangles use vertices of `source`.
void appendSimplified(const Scene& scene, const Mesh& source, const std::vector<std::uint32_t>& triangles, double keep,
                      Mesh& target) {
  const Welded welded = weld(scene, source, triangles);
  const auto targetCorners = 3 * static_cast<std::size_t>(std::ceil(keep * static_cast<double>(triangles.size())));
  std::vector<std::uint32_t> corners(welded.corners.size());
  corners.resize(meshopt_simplify(corners.data(), welded.corners.data(), welded.corners.size(),
                                  &welded.vertices.front().position.x, welded.vertices.size(), sizeof(Weld),
                                  targetCorners, kUnlimitedError, 0, nullptr));
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    target.triangles.push_back(
        {welded.vertexOf[corners[i]], welded.vertexOf[corners[i + 1]], welded.vertexOf[corners[i + 2]]});
    target.surfaceOf.push_back(static_cast<std::uint16_t>(welded.vertices[corners[i]].surface));
  }
}

std::vector<std::size_t> trianglesPerSurface(const Mesh& mesh) {
  std::vector<std::size_t> count(mesh.surfaces.size());
  for (const std::uint16_t s : mesh.surfaceOf) ++count[s];
  return count;
}

// Restores surfaces in `target` that vanished when `source` was simplified. A surface of more than kFewTriangles
// triangles is simplified again by itself. If it vanishes again, or has at most kFewTriangles triangles, all its
// original triangles are restored.
void restoreVanished(const Scene& scene, const Mesh& source, double keep, Mesh& target) {
  const std::vector<std::size_t> sourceCounts = trianglesPerSurface(source);
  const std::vector<std::size_t> targetCounts = trianglesPerSurface(target);
  for (std::size_t s = 0; s < sourceCounts.size(); ++s) {
    if (sourceCounts[s] == 0 || targetCounts[s] > 0) continue;
    std::vector<std::uint32_t> lost;
    for (std::uint32_t t = 0; t < source.triangles.size(); ++t) {
      if (source.surfaceOf[t] == s) lost.push_back(t);
    }
    Mesh restored;
    restored.positions = source.positions;
    if (lost.size() > kFewTriangles) {
      appendSimplified(scene, source, lost, keep, restored);
      static_cast<void>(clean(restored));
    }
    if (restored.triangles.empty()) {
      for (const std::uint32_t t : lost) {
        restored.triangles.push_back(source.triangles[t]);
        restored.surfaceOf.push_back(source.surfaceOf[t]);
      }
    }
    target.triangles.insert(target.triangles.end(), restored.triangles.begin(), restored.triangles.end());
    target.surfaceOf.insert(target.surfaceOf.end(), restored.surfaceOf.begin(), restored.surfaceOf.end());
  }
}

// Drops vertices that no triangle uses. The mesh must have triangles, which restoreVanished() ensures.
void compact(Mesh& mesh) {
  static_assert(sizeof(Triangle) == 3 * sizeof(unsigned));
  unsigned* const corners = mesh.triangles.front().data();
  const std::size_t vertexCount = mesh.positions.size();
  std::vector<unsigned> newIndices(vertexCount);
  const std::size_t usedCount =
      meshopt_optimizeVertexFetchRemap(newIndices.data(), corners, mesh.triangles.size() * 3, vertexCount);
  const auto keepUsed = [&](auto& values) {
    if (values.empty()) return;
    std::decay_t<decltype(values)> compacted(usedCount);
    meshopt_remapVertexBuffer(compacted.data(), values.data(), vertexCount, sizeof compacted.front(),
                              newIndices.data());
    values = std::move(compacted);
  };
  keepUsed(mesh.positions);
  keepUsed(mesh.uvs);
  meshopt_remapIndexBuffer(corners, corners, mesh.triangles.size() * 3, newIndices.data());
}

// Reduces `target`, which is a copy of `source`, to about the fraction `keep` of its triangles.
void simplify(const Scene& scene, const Mesh& source, double keep, Mesh& target) {
  if (source.triangles.size() <= kFewTriangles) return;
  std::vector<std::uint32_t> allTriangles(source.triangles.size());
  std::iota(allTriangles.begin(), allTriangles.end(), 0U);
  target.triangles.clear();
  target.surfaceOf.clear();
  appendSimplified(scene, source, allTriangles, keep, target);
  static_cast<void>(clean(target));
  restoreVanished(scene, source, keep, target);
  target.triangles.shrink_to_fit();
  target.surfaceOf.shrink_to_fit();
  compact(target);
}

}  // namespace

Scene simplified(const Scene& scene, double keep) {
  if (!(keep > 0 && keep <= 1)) throw Error("a share of {} of the triangles cannot be kept", keep);
  Scene result = scene;
  if (keep == 1) return result;
  parallelForEach(scene.meshes.size(), 1,
                  [&](std::size_t m) { simplify(scene, scene.meshes[m], keep, result.meshes[m]); });
  return result;
}

}  // namespace scanmill
