#include "assets/meshes/asset_parts.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <utility>

#include "formats/cloud_file.h"

namespace scanmill {

Mat3 zUpFrom(char up) {
  if (up == 'x') return {{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}};
  if (up == 'y') return {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
  return {};
}

Mat3 assetFromFile(char up, double metresPerUnit) {
  return zUpFrom(up) * Mat3::scale({metresPerUnit, metresPerUnit, metresPerUnit});
}

void placePositions(std::vector<Vec3d>& positions, bool exact, const AssetOptions& options, Asset& asset) {
  asset.up = options.up.value_or('z');
  const Mat3 frame = assetFromFile(asset.up, options.metresPerUnit);
  for (Vec3d& position : positions) position = frame * position;
  if (!exact) return;
  constexpr std::size_t kFewestSamples = 1000;  // least number of samples, unless there are fewer positions
  const std::size_t step = std::max<std::size_t>(positions.size() / kFewestSamples, 1);
  std::vector<Vec3d> samples;
  for (std::size_t i = 0; i < positions.size(); i += step) {
    if (isFinite(positions[i])) samples.push_back(positions[i]);
  }
  if (samples.empty()) return;
  const auto median = [&](double Vec3d::*axis) {
    const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
    std::ranges::nth_element(samples, middle, {}, axis);
    return (*middle).*axis;
  };
  asset.origin = cloudOrigin({median(&Vec3d::x), median(&Vec3d::y), median(&Vec3d::z)});
}

void weld(AssetPart& part) {
  std::vector<Vec3f>& positions = part.positions;
  std::vector<Vec2f>& uvs = part.uvs;
  const std::size_t count = positions.size();
  std::vector<bool> isUsed(count, false);
  for (const Triangle& triangle : part.triangles) {
    for (const std::uint32_t corner : triangle) isUsed[corner] = true;
  }
  // A mesh with at most two vertices per triangle shares its vertices already, and rarely has identical ones.
  const bool sharesVertices = count <= 2 * part.triangles.size();
  if (sharesVertices && std::ranges::find(isUsed, false) == isUsed.end()) return;
  std::vector<std::uint32_t> usedVertices;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (isUsed[i]) usedVertices.push_back(i);
  }
  while (usedVertices.size() % 3 != 0) usedVertices.push_back(usedVertices.back());  // meshoptimizer expects triangles
  const std::array<meshopt_Stream, 2> streams{
      {{positions.data(), sizeof(Vec3f), sizeof(Vec3f)}, {uvs.data(), sizeof(Vec2f), sizeof(Vec2f)}}};
  std::vector<std::uint32_t> newIndex(count);
  const std::size_t newCount = meshopt_generateVertexRemapMulti(
      newIndex.data(), usedVertices.data(), usedVertices.size(), count, streams.data(), uvs.empty() ? 1 : 2);
  const auto moveVertices = [&](auto& values) {
    if (values.empty()) return;
    meshopt_remapVertexBuffer(values.data(), values.data(), count, sizeof values[0], newIndex.data());
    values.resize(newCount);
    values.shrink_to_fit();
  };
  moveVertices(positions);
  moveVertices(uvs);
  for (Triangle& triangle : part.triangles) {
    for (std::uint32_t& corner : triangle) corner = newIndex[corner];
  }
}

void makeTriangles(AssetPart& part) {
  const auto vertices = static_cast<std::uint32_t>(part.positions.size());
  for (std::uint32_t i = 0; i + 2 < vertices; i += 3) part.triangles.push_back({i, i + 1, i + 2});
  weld(part);
}

void append(const Geometry& geometry, const Affine& assetFromNode, std::uint32_t material, bool needsUvs,
            std::size_t first, std::vector<AssetPart>& parts) {
  if (geometry.points.empty()) return;
  const auto takesGeometry = [&](const AssetPart& part) {
    return part.materialIndex == material && !(needsUvs && part.uvs.empty() != geometry.uvs.empty());
  };
  auto part = std::find_if(parts.begin() + static_cast<std::ptrdiff_t>(first), parts.end(), takesGeometry);
  if (part == parts.end()) {
    parts.emplace_back().materialIndex = material;
    part = parts.end() - 1;
  }
  const auto base = static_cast<std::uint32_t>(part->positions.size());  // index of the first new vertex
  for (const Vec3d& p : geometry.points) part->positions.push_back(static_cast<Vec3f>(assetFromNode * p));
  if (!geometry.uvs.empty() || !part->uvs.empty()) {
    part->uvs.resize(base);  // zeros for geometry without texture coordinates
    part->uvs.insert(part->uvs.end(), geometry.uvs.begin(), geometry.uvs.end());
    part->uvs.resize(part->positions.size());
  }
  const bool mirrored = determinant(assetFromNode.linear) < 0;
  for (const Triangle& t : geometry.triangles) {
    part->triangles.push_back({base + t[0], base + t[mirrored ? 2 : 1], base + t[mirrored ? 1 : 2]});
  }
}

void finishNode(std::string_view name, std::uint32_t nodeIndex, std::size_t first, std::vector<AssetPart>& parts) {
  const auto begin = parts.begin() + static_cast<std::ptrdiff_t>(first);
  parts.erase(std::remove_if(begin, parts.end(), [](const AssetPart& p) { return p.triangles.empty(); }), parts.end());
  for (std::size_t i = first; i < parts.size(); ++i) {
    AssetPart& part = parts[i];
    part.node = name;
    part.nodeIndex = nodeIndex;
    weld(part);
  }
}

void move(AssetPart& part, const Affine& transform) {
  for (Vec3f& p : part.positions) p = static_cast<Vec3f>(transform * Vec3d(p));
  if (determinant(transform.linear) > 0) return;
  for (Triangle& t : part.triangles) std::swap(t[1], t[2]);
}

void checkTexture(AssetPart& part, bool repeats, LeftOut& leftOut) {
  Material& material = part.fileMaterial;
  if (part.texture.empty() && material.texture == nullptr) return;
  constexpr float kTolerance = 1e-3f;  // ratio to the image's size; allows for rounding by exporters
  const auto isInside = [](float u) { return u > -kTolerance && u < 1 + kTolerance; };
  if (part.uvs.empty()) {
    leftOut.add("textures of parts without texture coordinates");
    material.texture = nullptr;
    material.textured = material.alphaTested = false;
  } else if (!repeats &&
             !std::ranges::all_of(part.uvs, [&](const Vec2f& uv) { return isInside(uv.x) && isInside(uv.y); })) {
    leftOut.add("clamped or mirrored textures (they repeat)");
  }
}

Box boundsOf(const Asset& asset) {
  Box box;
  const auto addVertices = [&](const AssetPart& part, const Affine& assetFromPart) {
    for (const Vec3f& p : part.positions) {
      if (isFinite(p)) box.add(assetFromPart * Vec3d(p));
    }
  };
  for (const AssetPart& part : asset.parts) addVertices(part, {{}, asset.origin});
  for (const InstancedParts& instanced : asset.instanced) {
    for (const Affine& assetFromPart : instanced.assetFromParts) {
      for (const AssetPart& part : instanced.parts) addVertices(part, assetFromPart);
    }
  }
  return box;
}

void flatten(Asset& asset) {
  std::uint32_t nodes = 0;  // number of node indices used so far
  for (const AssetPart& part : asset.parts) nodes = std::max(nodes, part.nodeIndex + 1);
  for (const InstancedParts& instanced : asset.instanced) {
    for (const Affine& assetFromPart : instanced.assetFromParts) {
      for (AssetPart part : instanced.parts) {
        move(part, assetFromPart);
        part.nodeIndex = nodes;
        asset.parts.push_back(std::move(part));
      }
      ++nodes;
    }
  }
  asset.instanced.clear();
}

}  // namespace scanmill
