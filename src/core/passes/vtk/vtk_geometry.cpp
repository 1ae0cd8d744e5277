#include "passes/vtk/vtk_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "base/error.h"
#include "base/parallel.h"
#include "scene/reflectance.h"

namespace scanmill {

namespace {

// Largest number of triangles of a chunk. With larger chunks, more triangles outside of the image are drawn; with
// smaller chunks, there are more draw calls.
constexpr std::size_t kChunkTriangles = 1024;

// Edges longer than kLongestEdge (m, world) are halved, unless they are shorter than kFraction * the mesh's size. The
// reason is that llvmpipe interpolates depth in float32 across the complete triangle, even if its corners are clipped
// away: the relative error is 1e-4 for a triangle of 20 km, and 1e-5 below 1 km. This depth only decides which triangle
// is visible; the depth that is returned is computed in double precision (see DrawnView::triangleAt).
constexpr double kLongestEdge = 256;
constexpr double kFraction = 1.0 / 256;

struct Corner {
  Vec3f position;  // m, relative to the mesh's origin
  Vec2f uv;
};

// A triangle of a mesh, or a part of a triangle.
struct Piece {
  std::array<Corner, 3> corners;
  std::uint32_t original = 0;  // index into Mesh::triangles
  std::uint32_t cutout = 0;    // index into ViewGeometry::cutouts; 0 in solid pieces, which have none

  Vec3f centroidTimes3() const { return corners[0].position + corners[1].position + corners[2].position; }
};

struct MeshPieces {
  ViewMesh mesh;  // without the ranges of chunks
  ViewBatch solid;
  ViewBatch cut;
};

// Returns, for one axis, the origin that is subtracted from a mesh's positions: 0, or the middle of a mesh that is far
// from 0, where float32 steps are coarse. The subtraction is exact, because position and origin are then within a
// factor of two of each other (Sterbenz).
double originOf(double low, double high) {
  const double middle = (low + high) / 2;
  return std::abs(middle) > 2 * (high - low) ? double{static_cast<float>(middle)} : 0.0;
}

// Halves a piece at its longest edge until no edge is longer than `longest` (m), and appends the parts to `pieces`. Two
// triangles split a common edge at the same points, whatever their other edges are, so that no gap opens between them.
void splitLongEdges(const Piece& piece, float longest, std::vector<Piece>& pieces) {
  const auto squaredLength = [&](std::size_t edge) {
    const Vec3f along = piece.corners[(edge + 1) % 3].position - piece.corners[edge].position;
    return dot(along, along);
  };
  const std::array<float, 3> lengths2{squaredLength(0), squaredLength(1), squaredLength(2)};
  const auto i = static_cast<std::size_t>(std::ranges::max_element(lengths2) - lengths2.begin());
  if (!(lengths2[i] > longest * longest)) return pieces.push_back(piece);
  const std::size_t j = (i + 1) % 3;
  const Corner& a = piece.corners[i];
  const Corner& b = piece.corners[j];
  const Corner middle{(a.position + b.position) * 0.5f, {(a.uv.x + b.uv.x) * 0.5f, (a.uv.y + b.uv.y) * 0.5f}};
  const bool tooShortForFloat32 = middle.position == a.position || middle.position == b.position;
  if (tooShortForFloat32) return pieces.push_back(piece);
  Piece firstHalf = piece;
  firstHalf.corners[j] = middle;
  splitLongEdges(firstHalf, longest, pieces);
  Piece secondHalf = piece;
  secondHalf.corners[i] = middle;
  splitLongEdges(secondHalf, longest, pieces);
}

// Appends a chunk of these pieces to the batch.
void appendChunk(std::span<const Piece> pieces, bool cut, ViewBatch& batch) {
  const auto firstTriangle = static_cast<std::uint32_t>(batch.original.size());
  Box box;
  for (const Piece& piece : pieces) {
    batch.original.push_back(piece.original);
    for (const Corner& corner : piece.corners) {
      const Vec3f& p = corner.position;
      batch.positions.insert(batch.positions.end(), {p.x, p.y, p.z});
      box.add(Vec3d(p));
      if (!cut) continue;
      batch.uvs.insert(batch.uvs.end(), {corner.uv.x, corner.uv.y});
      batch.cutouts.push_back(piece.cutout);
    }
  }
  batch.chunks.push_back({firstTriangle, static_cast<std::uint32_t>(pieces.size()), Vec3f(box.low), Vec3f(box.high)});
}

// Halves a set of pieces at the median of their centres, along the longest axis of their bounds, until each half fits
// into a chunk, and appends the chunks to the batch. `cut`: true if the pieces have cut-outs.
void cutIntoChunks(std::span<Piece> pieces, bool cut, ViewBatch& batch) {
  if (pieces.empty()) return;
  if (pieces.size() <= kChunkTriangles) {
    std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.original < b.original; });
    appendChunk(pieces, cut, batch);
    return;
  }
  Box box;
  for (const Piece& piece : pieces) box.add(Vec3d(piece.centroidTimes3()));
  const Vec3d size = box.high - box.low;
  float Vec3f::*axis = &Vec3f::x;
  if (size.y > size.x) axis = &Vec3f::y;
  if (size.z > std::max(size.x, size.y)) axis = &Vec3f::z;
  const std::size_t half = pieces.size() / 2;
  std::nth_element(pieces.begin(), pieces.begin() + static_cast<std::ptrdiff_t>(half), pieces.end(),
                   [&](const Piece& a, const Piece& b) { return a.centroidTimes3().*axis < b.centroidTimes3().*axis; });
  cutIntoChunks(pieces.first(half), cut, batch);
  cutIntoChunks(pieces.subspan(half), cut, batch);
}

constexpr std::uint32_t kSolid = 0xFFFFFFFFu;

// Returns a mesh divided into chunks. `largestScale`: largest factor by which an instance stretches the mesh.
// `cutoutOf`, by material of the scene: index of the material's cut-out, or kSolid.
MeshPieces divideMesh(const Mesh& mesh, double largestScale, const std::vector<std::uint32_t>& cutoutOf) {
  MeshPieces divided;
  const Box bounds = mesh.bounds();
  if (bounds.empty()) return divided;
  const Vec3d origin{originOf(bounds.low.x, bounds.high.x), originOf(bounds.low.y, bounds.high.y),
                     originOf(bounds.low.z, bounds.high.z)};
  divided.mesh = {
      .origin = origin, .low = Vec3f(bounds.low - origin), .high = Vec3f(bounds.high - origin), .solid = {}, .cut = {}};
  const Vec3d size = bounds.high - bounds.low;
  const auto longestEdge =
      static_cast<float>(std::max(kLongestEdge / largestScale, std::max({size.x, size.y, size.z}) * kFraction));

  std::vector<Piece> solid;
  std::vector<Piece> cut;
  solid.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Piece piece;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t corner = mesh.triangles[t][i];
      piece.corners[i] = {mesh.positions[corner] - Vec3f(origin), mesh.uvs.empty() ? Vec2f{} : mesh.uvs[corner]};
    }
    piece.original = static_cast<std::uint32_t>(t);
    const std::uint32_t cutout = cutoutOf[mesh.surfaces[mesh.surfaceOf[t]].material];
    piece.cutout = cutout == kSolid ? 0 : cutout;
    splitLongEdges(piece, longestEdge, cutout == kSolid ? solid : cut);
  }
  cutIntoChunks(solid, false, divided.solid);
  cutIntoChunks(cut, true, divided.cut);
  return divided;
}

// Adds the bitmaps of all alpha-tested materials to `geometry`. Returns, by material, the index of its cut-out, or
// kSolid if the material has none.
std::vector<std::uint32_t> addCutouts(const Scene& scene, ViewGeometry& geometry) {
  std::vector<std::uint32_t> cutoutOf(scene.materials.size(), kSolid);
  for (std::size_t m = 0; m < scene.materials.size(); ++m) {
    const Material& material = scene.materials[m];
    if (!material.alphaTested || material.texture == nullptr) continue;
    cutoutOf[m] = static_cast<std::uint32_t>(geometry.cutouts.size());
    const Texture& texture = *material.texture;
    const std::size_t firstWord = geometry.cutoutWords.size();
    const std::size_t texels = std::size_t{texture.width} * texture.height;
    geometry.cutouts.push_back({static_cast<std::uint32_t>(firstWord), texture.width, texture.height, 0});
    geometry.cutoutWords.resize(firstWord + (texels + 31) / 32);
    for (std::size_t i = 0; i < texels; ++i) {
      const bool isTransparent = letsPass(material, &texture.rgba[i * 4]);
      geometry.cutoutWords[firstWord + i / 32] |= std::uint32_t{isTransparent} << (i % 32);
    }
  }
  return cutoutOf;
}

// Appends a mesh's batch to `batch`. Returns the range of indices that the mesh's chunks have in `batch`.
ChunkRange append(ViewBatch& batch, ViewBatch&& meshBatch) {
  const ChunkRange range{static_cast<std::uint32_t>(batch.chunks.size()),
                         static_cast<std::uint32_t>(batch.chunks.size() + meshBatch.chunks.size())};
  const auto firstTriangle = static_cast<std::uint32_t>(batch.original.size());
  for (ViewChunk& chunk : meshBatch.chunks) chunk.firstTriangle += firstTriangle;
  const auto append = [&](auto ViewBatch::*array) {
    const auto part = std::move(meshBatch.*array);  // freed after each array: memory never has two copies of the scene
    (batch.*array).insert((batch.*array).end(), part.begin(), part.end());
  };
  append(&ViewBatch::positions);
  append(&ViewBatch::uvs);
  append(&ViewBatch::cutouts);
  append(&ViewBatch::original);
  append(&ViewBatch::chunks);
  return range;
}

// Reserves space for triangles, with cut-outs if `cut` is true. Throws Error for more than `limit` triangles.
void reserve(ViewBatch& batch, std::uint64_t triangles, bool cut, std::uint64_t limit) {
  if (triangles > limit) {
    throw Error(
        "the scene has {} triangles, more than the {} that can be drawn at once: take ray tracing, or a smaller scene",
        triangles, limit);
  }
  batch.positions.reserve(triangles * 9);
  batch.original.reserve(triangles);
  if (!cut) return;
  batch.uvs.reserve(triangles * 6);
  batch.cutouts.reserve(triangles * 3);
}

}  // namespace

ViewGeometry buildViewGeometry(const Scene& scene, std::uint64_t trianglesPerBatch) {
  ViewGeometry geometry;
  const std::vector<std::uint32_t> cutoutOf = addCutouts(scene, geometry);
  std::vector<double> largestScale(scene.meshes.size(), 0.0);
  for (const Instance& instance : scene.instances) {
    double& scale = largestScale[instance.mesh];
    const Mat3& axes = instance.worldFromMesh.linear;
    scale = std::max({scale, length(axes.x), length(axes.y), length(axes.z)});
  }
  std::vector<MeshPieces> meshes(scene.meshes.size());
  parallelForEach(meshes.size(), 1, [&](std::size_t m) {
    if (largestScale[m] > 0) meshes[m] = divideMesh(scene.meshes[m], largestScale[m], cutoutOf);
  });
  std::uint64_t solidTriangles = 0;
  std::uint64_t cutTriangles = 0;
  for (const MeshPieces& pieces : meshes) {
    solidTriangles += pieces.solid.original.size();
    cutTriangles += pieces.cut.original.size();
  }
  reserve(geometry.solid, solidTriangles, false, trianglesPerBatch);
  reserve(geometry.cut, cutTriangles, true, trianglesPerBatch);
  for (MeshPieces& pieces : meshes) {
    pieces.mesh.solid = append(geometry.solid, std::move(pieces.solid));
    pieces.mesh.cut = append(geometry.cut, std::move(pieces.cut));
    geometry.meshes.push_back(pieces.mesh);
  }
  return geometry;
}

}  // namespace scanmill
