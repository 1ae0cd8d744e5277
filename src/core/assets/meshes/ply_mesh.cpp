#include "assets/meshes/ply_mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "assets/meshes/asset_parts.h"
#include "assets/meshes/ply_check.h"
#include "base/file.h"
#include "formats/cloud_file.h"
#include "formats/ply_header.h"

namespace scanmill {

namespace {

static_assert(std::endian::native == std::endian::little);

// The offset (bytes) and the type of a coordinate in a vertex.
struct Axis {
  std::uint64_t at = 0;
  bool isDouble = false;
};

struct Layout {
  std::array<Axis, 3> axes;
  std::uint64_t vertexBytes = 0;
  std::uint64_t faceBytes = 0;  // bytes of a face, with all its properties
  std::uint64_t vertices = 0;
  std::uint64_t faces = 0;

  bool exact() const {
    return std::any_of(axes.begin(), axes.end(), [](const Axis& axis) { return axis.isDouble; });
  }
};

bool isTextureCoordinate(std::string_view name) {
  constexpr std::array<std::string_view, 6> kNames{"s", "t", "u", "v", "texture_u", "texture_v"};
  return std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

bool readVertex(const PlyElement& vertex, Layout& layout) {
  constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};
  std::array<bool, 3> found{};
  for (const PlyProperty& p : vertex.properties) {
    if (p.isList() || isTextureCoordinate(p.name)) return false;
    const auto axis = static_cast<std::size_t>(std::find(kAxes.begin(), kAxes.end(), p.name) - kAxes.begin());
    if (axis < kAxes.size()) {
      if (p.value.kind != PlyType::Kind::Float || found[axis]) return false;
      found[axis] = true;
      layout.axes[axis] = {layout.vertexBytes, p.value.size == 8};
    }
    layout.vertexBytes += p.value.size;
  }
  layout.vertices = vertex.count;
  return found == std::array<bool, 3>{true, true, true};
}

bool readFace(const PlyElement& face, Layout& layout) {
  const auto& list = face.properties;
  if (list.empty() || (list.front().name != "vertex_indices" && list.front().name != "vertex_index")) return false;
  if (list.front().count.size != 1 || list.front().value.size != 4 || list.front().value.kind == PlyType::Kind::Float) {
    return false;
  }
  layout.faceBytes = 1 + sizeof(Triangle);
  for (std::size_t i = 1; i < list.size(); ++i) {
    if (list[i].isList()) return false;
    layout.faceBytes += list[i].value.size;
  }
  layout.faces = face.count;
  return true;
}

std::optional<Layout> layoutOf(const PlyHeader& header) {
  Layout layout;
  if (header.format != PlyHeader::Format::LittleEndian || header.elements.size() != 2 ||
      header.elements[0].name != "vertex" || header.elements[1].name != "face" ||
      !readVertex(header.elements[0], layout) || !readFace(header.elements[1], layout) ||
      layout.vertices > UINT32_MAX || layout.faces > kMostTriangles) {
    return std::nullopt;
  }
  return layout;
}

Vec3d vertexAt(const char* bytes, const Layout& layout) {
  std::array<double, 3> p{};
  for (std::size_t k = 0; k < 3; ++k) {
    float single = 0;
    if (layout.axes[k].isDouble) {
      std::memcpy(&p[k], bytes + layout.axes[k].at, sizeof p[k]);
    } else {
      std::memcpy(&single, bytes + layout.axes[k].at, sizeof single);
      p[k] = double{single};
    }
  }
  return {p[0], p[1], p[2]};
}

// Returns an origin near most vertices (m, along the asset's axes): the median of at most 2000 vertices, which ignores
// outliers.
Vec3d originOf(const char* bytes, const Layout& layout, const Mat3& assetFromFile) {
  constexpr std::uint64_t kSamples = 1000;
  const std::uint64_t every = std::max<std::uint64_t>(layout.vertices / kSamples, 1);
  std::vector<Vec3d> places;
  for (std::uint64_t i = 0; i < layout.vertices; i += every) {
    places.push_back(assetFromFile * vertexAt(bytes + i * layout.vertexBytes, layout));
  }
  return originNear(places);
}

// Reads the triangles, and drops those with indices out of range. Returns false if a face is not a triangle.
bool readFaces(const char* bytes, const Layout& layout, ImportedFile& read) {
  std::vector<Triangle>& triangles = read.parts.front().triangles;
  triangles.resize(layout.faces);
  std::size_t kept = 0;
  for (std::uint64_t i = 0; i < layout.faces; ++i, bytes += layout.faceBytes) {
    if (*bytes != 3) return false;
    Triangle& triangle = triangles[kept];
    std::memcpy(triangle.data(), bytes + 1, sizeof triangle);
    kept += std::max({triangle[0], triangle[1], triangle[2]}) < layout.vertices ? 1u : 0u;
  }
  triangles.resize(kept);
  read.outOfRange = layout.faces - kept;
  return true;
}

}  // namespace

std::optional<ImportedFile> readPlyMesh(const std::filesystem::path& file, const AssetOptions& options) {
  const PlyHeader header = readPlyHeader(file);
  const std::optional<Layout> layout = layoutOf(header);
  if (!layout) return std::nullopt;
  const std::string bytes = readFile(file);
  if (bytes.size() < header.size + layout->vertices * layout->vertexBytes + layout->faces * layout->faceBytes) {
    return std::nullopt;
  }
  // In MeshLab's files a comment with this word names a texture image; the importer reads such files.
  if (std::string_view(bytes).substr(0, header.size).find("TextureFile") != std::string_view::npos) return std::nullopt;
  ImportedFile read;
  read.up = options.up.value_or('z');
  read.materials.emplace_back().stated = false;
  ImportedPart& part = read.parts.emplace_back();
  const char* const vertices = bytes.data() + header.size;
  if (!readFaces(vertices + layout->vertices * layout->vertexBytes, *layout, read)) return std::nullopt;

  const Mat3 assetFromFile = zUpFrom(read.up) * Mat3::scale(Vec3d{1, 1, 1} * options.metresPerUnit);
  if (layout->exact()) read.origin = originOf(vertices, *layout, assetFromFile);
  part.positions.resize(layout->vertices);
  for (std::uint64_t i = 0; i < layout->vertices; ++i) {
    const Vec3d place = assetFromFile * vertexAt(vertices + i * layout->vertexBytes, *layout);
    part.positions[i] = static_cast<Vec3f>(place - read.origin);
  }
  weld(part.positions, part.uvs, part.triangles);
  tellLeftOut(header, file);
  if (part.triangles.empty()) read.parts.clear();
  return read;
}

}  // namespace scanmill
