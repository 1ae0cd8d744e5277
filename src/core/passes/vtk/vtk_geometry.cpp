#include "passes/vtk/vtk_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "base/error.h"
#include "base/parallel.h"
#include "scene/reflectance.h"

namespace scanmill {

namespace {

// Largest number of triangles in a chunk. With larger chunks more of the drawn triangles are outside of the image;
// smaller chunks need more draw calls.
constexpr std::size_t kChunk = 1024;

// Edges longer than kLongestEdge (m, world) are halved, unless they are shorter than kFraction of the mesh's size. The
// reason is that llvmpipe interpolates depth in float32 across the complete triangle, even if its corners are clipped
// away: the relative error is 1e-4 for a triangle of 20 km, and 1e-5 below 1 km. This depth only decides which triangle
// is visible; the depth that is returned is computed in double precision (see DrawnView::seen).
constexpr double kLongestEdge = 256;
constexpr double kFraction = 1.0 / 256;

struct Corner {
  Vec3f position;  // m, relative to the mesh's origin
  Vec2f uv;
};

struct Piece {
  std::array<Corner, 3> corners;
  std::uint32_t original = 0;
  std::uint32_t cutout = 0;

  Vec3f middle() const { return corners[0].position + corners[1].position + corners[2].position; }
};

struct MeshPieces {
  ViewMesh mesh;
  ViewBatch solid;
  ViewBatch cut;
};

// Returns the largest factor by which an instance stretches an axis of its mesh.
double largestStretch(const Instance& instance) {
  const Mat3& m = instance.worldFromMesh.linear;
  return std::max({length(m.x), length(m.y), length(m.z)});
}

// Returns, for one axis, the origin that is subtracted from a mesh's positions. Far from zero float32 steps are coarse,
// so the origin is then the middle of the mesh. The subtraction is exact, because position and origin are
// within a factor of two of each other (Sterbenz).
double originOf(double low, double high) {
  const double middle = (low + high) / 2;
  return std::abs(middle) > 2 * (high - low) ? double{static_cast<float>(middle)} : 0.0;
}

// Halves the longest edge until no edge is longer than `longest`. Triangles that share an edge split it at the same
// points, whatever their other edges are, so that no gap opens between the triangles.
void splitLongEdges(const Piece& piece, float longest, std::vector<Piece>& pieces) {
  const auto squared = [&](std::size_t i) {
    const Vec3f edge = piece.corners[(i + 1) % 3].position - piece.corners[i].position;
    return dot(edge, edge);
  };
  const std::array<float, 3> lengths{squared(0), squared(1), squared(2)};
  const auto i = static_cast<std::size_t>(std::max_element(lengths.begin(), lengths.end()) - lengths.begin());
  if (!(lengths[i] > longest * longest)) return pieces.push_back(piece);
  const std::size_t j = (i + 1) % 3;
  const Corner& a = piece.corners[i];
  const Corner& b = piece.corners[j];
  const Corner half{(a.position + b.position) * 0.5f, {(a.uv.x + b.uv.x) * 0.5f, (a.uv.y + b.uv.y) * 0.5f}};
  if (half.position == a.position || half.position == b.position) {  // the edge is too short to be halved in float32
    pieces.push_back(piece);
    return;
  }
  Piece firstHalf = piece;
  firstHalf.corners[j] = half;
  splitLongEdges(firstHalf, longest, pieces);
  Piece secondHalf = piece;
  secondHalf.corners[i] = half;
  splitLongEdges(secondHalf, longest, pieces);
}

void appendChunk(std::span<const Piece> pieces, bool cut, ViewBatch& batch) {
  ViewChunk chunk;
  chunk.firstTriangle = static_cast<std::uint32_t>(batch.original.size());
  chunk.triangles = static_cast<std::uint32_t>(pieces.size());
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
  chunk.low = Vec3f(box.low);
  chunk.high = Vec3f(box.high);
  batch.chunks.push_back(chunk);
}

// Halves a set of pieces at the median of their centres, along the longest axis of their bounds, until each half fits
// into a chunk.
void cutIntoChunks(std::span<Piece> pieces, bool cut, ViewBatch& batch) {
  if (pieces.empty()) return;
  if (pieces.size() <= kChunk) {
    std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.original < b.original; });
    appendChunk(pieces, cut, batch);
    return;
  }
  Box box;
  for (const Piece& piece : pieces) box.add(Vec3d(piece.middle()));
  const Vec3d size = box.high - box.low;
  float Vec3f::*axis = &Vec3f::x;
  if (size.y > size.x) axis = &Vec3f::y;
  if (size.z > std::max(size.x, size.y)) axis = &Vec3f::z;
  const std::size_t half = pieces.size() / 2;
  std::nth_element(pieces.begin(), pieces.begin() + static_cast<std::ptrdiff_t>(half), pieces.end(),
                   [&](const Piece& a, const Piece& b) { return a.middle().*axis < b.middle().*axis; });
  cutIntoChunks(pieces.first(half), cut, batch);
  cutIntoChunks(pieces.subspan(half), cut, batch);
}

constexpr std::uint32_t kSolid = 0xFFFFFFFFu;

// Returns a mesh cut into chunks. `cutoutOf`, by material of the scene: index of the material's cut-out, or kSolid.
MeshPieces cutMesh(const Mesh& mesh, double largestScale, const std::vector<std::uint32_t>& cutoutOf) {
  MeshPieces made;
  const Box bounds = mesh.bounds();
  if (bounds.empty()) return made;
  made.mesh.origin = {originOf(bounds.low.x, bounds.high.x), originOf(bounds.low.y, bounds.high.y),
                      originOf(bounds.low.z, bounds.high.z)};
  made.mesh.low = Vec3f(bounds.low - made.mesh.origin);
  made.mesh.high = Vec3f(bounds.high - made.mesh.origin);
  const Vec3d size = bounds.high - bounds.low;
  const auto longest =
      static_cast<float>(std::max(kLongestEdge / largestScale, std::max({size.x, size.y, size.z}) * kFraction));

  std::vector<Piece> solid;
  std::vector<Piece> cut;
  solid.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Piece piece;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t corner = mesh.triangles[t][i];
      piece.corners[i] = {mesh.positions[corner] - Vec3f(made.mesh.origin),
                          mesh.uvs.empty() ? Vec2f{} : mesh.uvs[corner]};
    }
    piece.original = static_cast<std::uint32_t>(t);
    const std::uint32_t cutout = cutoutOf[mesh.surfaces[mesh.surfaceOf[t]].material];
    piece.cutout = cutout == kSolid ? 0 : cutout;
    splitLongEdges(piece, longest, cutout == kSolid ? solid : cut);
  }
  cutIntoChunks(solid, false, made.solid);
  cutIntoChunks(cut, true, made.cut);
  return made;
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
    const std::size_t first = geometry.cutoutWords.size();
    const std::size_t texels = std::size_t{texture.width} * texture.height;
    geometry.cutouts.push_back({static_cast<std::uint32_t>(first), texture.width, texture.height, 0});
    geometry.cutoutWords.resize(first + (texels + 31) / 32);
    for (std::size_t i = 0; i < texels; ++i) {
      const bool open = letsPass(material, &texture.rgba[i * 4]);
      geometry.cutoutWords[first + i / 32] |= std::uint32_t{open} << (i % 32);
    }
  }
  return cutoutOf;
}

ChunkRange append(ViewBatch& batch, ViewBatch&& more) {
  const ChunkRange range{static_cast<std::uint32_t>(batch.chunks.size()),
                         static_cast<std::uint32_t>(batch.chunks.size() + more.chunks.size())};
  const auto first = static_cast<std::uint32_t>(batch.original.size());
  for (ViewChunk& chunk : more.chunks) chunk.firstTriangle += first;
  const auto join = [](auto& to, auto& from) {
    to.insert(to.end(), from.begin(), from.end());
    from = {};
  };
  join(batch.positions, more.positions);
  join(batch.uvs, more.uvs);
  join(batch.cutouts, more.cutouts);
  join(batch.original, more.original);
  join(batch.chunks, more.chunks);
  return range;
}

void reserve(ViewBatch& batch, std::uint64_t triangles, bool cut, std::uint64_t most) {
  if (triangles > most) {
    throw Error(
        fmt::format("the scene has {} triangles, more than the {} that can be drawn at once: take ray tracing, "
                    "or a smaller scene",
                    triangles, most));
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
    scale = std::max(scale, largestStretch(instance));
  }
  std::vector<MeshPieces> made(scene.meshes.size());
  parallelFor(made.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t m = first; m < last; ++m) {
      if (largestScale[m] > 0) made[m] = cutMesh(scene.meshes[m], largestScale[m], cutoutOf);
    }
  });
  std::uint64_t solid = 0;
  std::uint64_t cut = 0;
  for (const MeshPieces& pieces : made) {
    solid += pieces.solid.original.size();
    cut += pieces.cut.original.size();
  }
  reserve(geometry.solid, solid, false, trianglesPerBatch);
  reserve(geometry.cut, cut, true, trianglesPerBatch);
  for (MeshPieces& pieces : made) {
    pieces.mesh.solid = append(geometry.solid, std::move(pieces.solid));
    pieces.mesh.cut = append(geometry.cut, std::move(pieces.cut));
    geometry.meshes.push_back(pieces.mesh);
  }
  return geometry;
}

}  // namespace scanmill
