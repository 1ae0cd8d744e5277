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

Vec3d originNear(std::size_t count, const std::function<Vec3d(std::size_t)>& position) {
  std::array<std::vector<double>, 3> axes;
  const std::size_t every = std::max<std::size_t>(count / 1000, 1);
  for (std::size_t i = 0; i < count; i += every) {
    const Vec3d at = position(i);
    if (!isFinite(at)) continue;
    axes[0].push_back(at.x);
    axes[1].push_back(at.y);
    axes[2].push_back(at.z);
  }
  if (axes[0].empty()) return {};
  const auto median = [](std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  return cloudOrigin({median(axes[0]), median(axes[1]), median(axes[2])});
}

void weld(std::vector<Vec3f>& positions, std::vector<Vec2f>& uvs, std::vector<Triangle>& triangles) {
  const std::size_t count = positions.size();
  std::vector<bool> used(count, false);
  for (const Triangle& triangle : triangles) {
    for (const std::uint32_t corner : triangle) used[corner] = true;
  }
  if (count <= 2 * triangles.size() && std::find(used.begin(), used.end(), false) == used.end()) return;
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (used[i]) order.push_back(i);
  }
  while (order.size() % 3 != 0) order.push_back(order.back());  // meshoptimizer expects triangles
  const std::array<meshopt_Stream, 2> streams{
      {{positions.data(), sizeof(Vec3f), sizeof(Vec3f)}, {uvs.data(), sizeof(Vec2f), sizeof(Vec2f)}}};
  std::vector<std::uint32_t> newIndex(count);
  const std::size_t kept = meshopt_generateVertexRemapMulti(newIndex.data(), order.data(), order.size(), count,
                                                            streams.data(), uvs.empty() ? 1 : 2);
  meshopt_remapVertexBuffer(positions.data(), positions.data(), count, sizeof(Vec3f), newIndex.data());
  if (!uvs.empty()) meshopt_remapVertexBuffer(uvs.data(), uvs.data(), count, sizeof(Vec2f), newIndex.data());
  positions.resize(kept);
  positions.shrink_to_fit();
  if (!uvs.empty()) {
    uvs.resize(kept);
    uvs.shrink_to_fit();
  }
  for (Triangle& triangle : triangles) {
    for (std::uint32_t& corner : triangle) corner = newIndex[corner];
  }
}

void append(const Geometry& geometry, const Affine& assetFromNode, std::uint32_t material, bool needsUvs,
            std::size_t first, std::vector<AssetPart>& parts) {
  if (geometry.points.empty()) return;
  const auto isOf = [&](const AssetPart& part) {
    return part.materialIndex == material && !(needsUvs && part.uvs.empty() != geometry.uvs.empty());
  };
  auto part = std::find_if(parts.begin() + static_cast<std::ptrdiff_t>(first), parts.end(), isOf);
  if (part == parts.end()) {
    parts.emplace_back().materialIndex = material;
    part = parts.end() - 1;
  }
  const auto base = static_cast<std::uint32_t>(part->positions.size());
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

void finishNode(std::string_view name, std::uint32_t index, std::size_t first, std::vector<AssetPart>& parts) {
  const auto begin = parts.begin() + static_cast<std::ptrdiff_t>(first);
  parts.erase(std::remove_if(begin, parts.end(), [](const AssetPart& p) { return p.triangles.empty(); }), parts.end());
  for (std::size_t i = first; i < parts.size(); ++i) {
    AssetPart& part = parts[i];
    part.node = name;
    part.nodeIndex = index;
    weld(part.positions, part.uvs, part.triangles);
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
  constexpr float kClose = 1e-3f;
  const auto inside = [](float u) { return u > -kClose && u < 1 + kClose; };
  if (part.uvs.empty()) {
    leftOut.add("textures of parts without texture coordinates");
    material.texture = nullptr;
    material.textured = material.alphaTested = false;
  } else if (!repeats && !std::all_of(part.uvs.begin(), part.uvs.end(),
                                      [&](const Vec2f& uv) { return inside(uv.x) && inside(uv.y); })) {
    leftOut.add("clamped or mirrored textures (they repeat)");
  }
}

Box boundsOf(const Asset& asset) {
  Box box;
  const auto add = [&](const AssetPart& part, const Affine& assetFromPart) {
    for (const Vec3f& p : part.positions) {
      if (isFinite(p)) box.add(assetFromPart * Vec3d(p));
    }
  };
  for (const AssetPart& part : asset.parts) add(part, {{}, asset.origin});
  for (const InstancedParts& instanced : asset.instanced) {
    for (const Affine& assetFromPart : instanced.assetFromParts) {
      for (const AssetPart& part : instanced.parts) add(part, assetFromPart);
    }
  }
  return box;
}

void flatten(Asset& asset) {
  std::uint32_t nodes = 0;
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
