#include "assets/meshes/asset_parts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "formats/cloud_file.h"

namespace scanmill {

Mat3 zUpFrom(char up) {
  if (up == 'x') return {{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}};
  if (up == 'y') return {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
  return {};
}

Vec3d originNear(std::size_t count, const std::function<Vec3d(std::size_t)>& place) {
  std::array<std::vector<double>, 3> axes;
  const std::size_t every = std::max<std::size_t>(count / 1000, 1);
  for (std::size_t i = 0; i < count; i += every) {
    const Vec3d at = place(i);
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
  constexpr std::uint32_t kFree = UINT32_MAX;
  std::vector<std::uint32_t> table(std::bit_ceil(count * 2), kFree);
  std::vector<std::uint32_t> moved(count);
  std::uint32_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (!used[i]) continue;
    const Vec3f p = positions[i];
    const Vec2f uv = uvs.empty() ? Vec2f{} : uvs[i];
    std::uint64_t hash = 0;
    for (const float value : {p.x, p.y, p.z, uv.x, uv.y}) {
      hash = (hash ^ std::bit_cast<std::uint32_t>(value)) * 0x9E3779B97F4A7C15;
      hash ^= hash >> 29;
    }
    std::size_t slot = hash & (table.size() - 1);
    const auto same = [&](std::uint32_t other) {
      const auto bits = [](const auto& v) { return std::bit_cast<std::array<std::uint32_t, sizeof v / 4>>(v); };
      return bits(positions[other]) == bits(p) && (uvs.empty() || bits(uvs[other]) == bits(uv));
    };
    while (table[slot] != kFree && !same(table[slot])) slot = (slot + 1) & (table.size() - 1);
    if (table[slot] == kFree) {
      table[slot] = kept;
      positions[kept] = p;
      if (!uvs.empty()) uvs[kept] = uv;
      ++kept;
    }
    moved[i] = table[slot];
  }
  positions.resize(kept);
  positions.shrink_to_fit();
  if (!uvs.empty()) {
    uvs.resize(kept);
    uvs.shrink_to_fit();
  }
  for (Triangle& triangle : triangles) {
    for (std::uint32_t& corner : triangle) corner = moved[corner];
  }
}

void move(AssetPart& part, const Affine& place) {
  for (Vec3f& p : part.positions) p = static_cast<Vec3f>(place * Vec3d(p));
  if (determinant(place.linear) > 0) return;
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
  const auto add = [&](const AssetPart& part, const Affine& place) {
    for (const Vec3f& p : part.positions) {
      if (isFinite(p)) box.add(place * Vec3d(p));
    }
  };
  for (const AssetPart& part : asset.parts) add(part, {{}, asset.origin});
  for (const InstancedParts& instanced : asset.instanced) {
    for (const Affine& place : instanced.assetFromParts) {
      for (const AssetPart& part : instanced.parts) add(part, place);
    }
  }
  return box;
}

void flatten(Asset& asset) {
  std::uint32_t nodes = 0;
  for (const AssetPart& part : asset.parts) nodes = std::max(nodes, part.nodeIndex + 1);
  for (const InstancedParts& instanced : asset.instanced) {
    for (const Affine& place : instanced.assetFromParts) {
      for (AssetPart part : instanced.parts) {
        move(part, place);
        part.nodeIndex = nodes;
        asset.parts.push_back(std::move(part));
      }
      ++nodes;
    }
  }
  asset.instanced.clear();
}

}  // namespace scanmill
