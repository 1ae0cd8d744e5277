// simplified(): proxies with few triangles.

#include <fmt/core.h>
#include <meshoptimizer.h>

#include <cmath>
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
constexpr float kAnyError = 1e6f;

// Corners of triangles become one vertex if their Welds have the same bytes. Corners in different surfaces therefore
// stay separate, and every triangle keeps its surface. The seam between two surfaces still stays closed, since
// meshoptimizer moves vertices at equal positions together.
struct Weld {
  Vec3f position;
  Vec2f uv;  // zero if the surface has no texture
  std::uint32_t surface = 0;
};
static_assert(sizeof(Weld) == 24, "bytes between the members would be compared, too");

// Triangles with merged vertices. `vertexOf` gives each vertex's index in the mesh.
struct Welded {
  std::vector<Weld> vertices;
  std::vector<std::uint32_t> vertexOf;
  std::vector<std::uint32_t> corners;  // indices into `vertices`, three per triangle
};

// Merges the vertices with equal Welds of the triangles whose indices are in `chosen`.
Welded weld(const Scene& scene, const Mesh& mesh, const std::vector<std::uint32_t>& chosen) {
  std::vector<bool> textured(mesh.surfaces.size());
  for (std::size_t s = 0; s < textured.size(); ++s) {
    textured[s] = !mesh.uvs.empty() && scene.materials[mesh.surfaces[s].material].texture != nullptr;
  }
  std::vector<Weld> all;  // one per corner
  all.reserve(chosen.size() * 3);
  for (const std::uint32_t t : chosen) {
    const std::uint16_t surface = mesh.surfaceOf[t];
    for (const std::uint32_t vertex : mesh.triangles[t]) {
      // Adding zero replaces minus zero by zero: equal positions must have equal bytes.
      all.push_back({mesh.positions[vertex] + Vec3f{}, textured[surface] ? mesh.uvs[vertex] : Vec2f{}, surface});
    }
  }
  Welded welded;
  welded.corners.resize(all.size());
  const std::size_t count =
      meshopt_generateVertexRemap(welded.corners.data(), nullptr, all.size(), all.data(), all.size(), sizeof(Weld));
  welded.vertices.resize(count);
  welded.vertexOf.resize(count);
  for (std::size_t i = 0; i < all.size(); ++i) {
    welded.vertices[welded.corners[i]] = all[i];
    welded.vertexOf[welded.corners[i]] = mesh.triangles[chosen[i / 3]][i % 3];
  }
  return welded;
}

// Simplifies the chosen triangles of `from`, and appends the result to `to`. The new triangles use vertices of `from`.
void appendFewer(const Scene& scene, const Mesh& from, const std::vector<std::uint32_t>& chosen, double keep,
                 Mesh& to) {
  const Welded welded = weld(scene, from, chosen);
  const auto target = static_cast<std::size_t>(std::ceil(keep * static_cast<double>(chosen.size()))) * 3;
  std::vector<std::uint32_t> remaining(welded.corners.size());
  remaining.resize(meshopt_simplify(remaining.data(), welded.corners.data(), welded.corners.size(),
                                    &welded.vertices.front().position.x, welded.vertices.size(), sizeof(Weld), target,
                                    kAnyError, 0, nullptr));
  for (std::size_t i = 0; i < remaining.size(); i += 3) {
    to.triangles.push_back(
        {welded.vertexOf[remaining[i]], welded.vertexOf[remaining[i + 1]], welded.vertexOf[remaining[i + 2]]});
    to.surfaceOf.push_back(static_cast<std::uint16_t>(welded.vertices[remaining[i]].surface));
  }
}

std::vector<std::size_t> trianglesPerSurface(const Mesh& mesh) {
  std::vector<std::size_t> count(mesh.surfaces.size());
  for (const std::uint16_t s : mesh.surfaceOf) ++count[s];
  return count;
}

// Restores surfaces that vanished when the mesh was simplified. A surface of more than kFewTriangles triangles is
// simplified again by itself. If it vanishes again, or has at most kFewTriangles triangles, all its original triangles
// are restored.
void restoreVanished(const Scene& scene, const Mesh& from, double keep, Mesh& to) {
  const std::vector<std::size_t> before = trianglesPerSurface(from);
  const std::vector<std::size_t> after = trianglesPerSurface(to);
  for (std::size_t s = 0; s < before.size(); ++s) {
    if (before[s] == 0 || after[s] > 0) continue;
    std::vector<std::uint32_t> lost;
    for (std::uint32_t t = 0; t < from.triangles.size(); ++t) {
      if (from.surfaceOf[t] == s) lost.push_back(t);
    }
    Mesh alone;
    alone.positions = from.positions;
    if (lost.size() > kFewTriangles) {
      appendFewer(scene, from, lost, keep, alone);
      static_cast<void>(clean(alone));
    }
    if (alone.triangles.empty()) {
      for (const std::uint32_t t : lost) {
        alone.triangles.push_back(from.triangles[t]);
        alone.surfaceOf.push_back(from.surfaceOf[t]);
      }
    }
    to.triangles.insert(to.triangles.end(), alone.triangles.begin(), alone.triangles.end());
    to.surfaceOf.insert(to.surfaceOf.end(), alone.surfaceOf.begin(), alone.surfaceOf.end());
  }
}

// Drops vertices that no triangle uses. The mesh must have triangles, as restoreVanished() leaves some of each surface.
void compact(Mesh& mesh) {
  static_assert(sizeof(Triangle) == 3 * sizeof(unsigned));
  unsigned* const corners = mesh.triangles.front().data();
  const std::size_t before = mesh.positions.size();
  std::vector<unsigned> renamed(before);
  const std::size_t used = meshopt_optimizeVertexFetchRemap(renamed.data(), corners, mesh.triangles.size() * 3, before);
  const auto keep = [&](auto& of) {
    if (of.empty()) return;
    std::decay_t<decltype(of)> compacted(used);
    meshopt_remapVertexBuffer(compacted.data(), of.data(), before, sizeof compacted.front(), renamed.data());
    of = std::move(compacted);
  };
  keep(mesh.positions);
  keep(mesh.uvs);
  meshopt_remapIndexBuffer(corners, corners, mesh.triangles.size() * 3, renamed.data());
}

void simplify(const Scene& scene, const Mesh& from, double keep, Mesh& to) {
  if (from.triangles.size() <= kFewTriangles) return;
  std::vector<std::uint32_t> all(from.triangles.size());
  for (std::uint32_t t = 0; t < all.size(); ++t) all[t] = t;
  to.triangles.clear();
  to.surfaceOf.clear();
  appendFewer(scene, from, all, keep, to);
  static_cast<void>(clean(to));
  restoreVanished(scene, from, keep, to);
  to.triangles.shrink_to_fit();
  to.surfaceOf.shrink_to_fit();
  compact(to);
}

}  // namespace

Scene simplified(const Scene& scene, double keep) {
  if (!(keep > 0 && keep <= 1)) throw Error(fmt::format("a share of {} of the triangles cannot be kept", keep));
  Scene made = scene;
  if (keep == 1) return made;
  parallelFor(scene.meshes.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t m = first; m < last; ++m) simplify(scene, scene.meshes[m], keep, made.meshes[m]);
  });
  return made;
}

}  // namespace scanmill
