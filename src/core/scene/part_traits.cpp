#include "scene/part_traits.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <unordered_map>

#include "scene/assets/texture.h"

namespace scanmill {
namespace {

// For each vertex the first one at its place.
std::vector<std::uint32_t> firstAtPlace(const std::vector<Vec3f>& positions) {
  struct Hash {
    std::size_t operator()(const Vec3f& p) const {
      std::uint64_t hash = 0;
      for (const float value : {p.x, p.y, p.z}) {
        hash = (hash ^ std::bit_cast<std::uint32_t>(value + 0.0f)) * 0x9E3779B97F4A7C15;  // -0 is 0
        hash ^= hash >> 29;
      }
      return hash;
    }
  };
  struct Equal {
    bool operator()(const Vec3f& a, const Vec3f& b) const { return a.x == b.x && a.y == b.y && a.z == b.z; }
  };
  std::unordered_map<Vec3f, std::uint32_t, Hash, Equal> known;
  known.reserve(positions.size());
  std::vector<std::uint32_t> first;
  first.reserve(positions.size());
  for (const Vec3f& p : positions) {
    first.push_back(known.emplace(p, static_cast<std::uint32_t>(first.size())).first->second);
  }
  return first;
}

std::vector<double> sizesOf(const AssetPart& part) {
  std::vector<std::uint32_t> parent = firstAtPlace(part.positions);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Triangle& t : part.triangles) {
    const std::uint32_t first = root(t[0]);
    for (const std::uint32_t corner : {t[1], t[2]}) parent[root(corner)] = first;
  }
  std::vector<Box> boxes(part.positions.size());
  for (const Triangle& t : part.triangles) {
    Box& box = boxes[root(t[0])];
    for (const std::uint32_t corner : t) box.add(Vec3d(part.positions[corner]));
  }
  std::vector<double> sizes;
  sizes.reserve(part.triangles.size());
  for (const Triangle& t : part.triangles) {
    const Vec3d size = boxes[root(t[0])].high - boxes[root(t[0])].low;
    sizes.push_back(std::max({size.x, size.y, size.z}));
  }
  return sizes;
}

}  // namespace

PartTraits::PartTraits(const AssetPart& part, const PartFrame& frame, bool withSizes) : part_(part), frame_(frame) {
  if (withSizes) sizes_ = sizesOf(part);
}

Rgb PartTraits::colorAt(const Triangle& triangle) const {
  std::array<double, 3> linear{part_.color[0], part_.color[1], part_.color[2]};
  const Texture* const texture = part_.fileMaterial.texture.get();
  if (part_.fileMaterial.textured && texture != nullptr && !part_.uvs.empty()) {
    Vec2f uv{0, 0};
    for (const std::uint32_t corner : triangle) {
      uv.x += part_.uvs[corner].x / 3;
      uv.y += part_.uvs[corner].y / 3;
    }
    const std::uint8_t* const texel = texture->texel(uv.x, uv.y);
    for (std::size_t c = 0; c < 3; ++c) linear[c] *= linearOf(texel[c] / 255.0);
  }
  Rgb color{};
  for (std::size_t c = 0; c < 3; ++c) {
    color[c] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(srgbOf(linear[c]), 0.0, 1.0)));
  }
  return color;
}

TriangleTraits PartTraits::at(std::size_t triangle) const {
  const Triangle& t = part_.triangles[triangle];
  TriangleTraits traits;
  traits.color = colorAt(t);
  for (const std::uint32_t corner : t) traits.middle = traits.middle + Vec3d(part_.positions[corner]) * (1.0 / 3);
  traits.height = traits.middle.z - frame_.lowest;
  traits.middle = traits.middle + frame_.origin;
  const Vec3d a(part_.positions[t[0]]);
  const Vec3d normal = cross(Vec3d(part_.positions[t[1]]) - a, Vec3d(part_.positions[t[2]]) - a);
  traits.slope = std::atan2(std::hypot(normal.x, normal.y), std::fabs(normal.z));
  if (!sizes_.empty()) traits.size = sizes_[triangle];
  return traits;
}

}  // namespace scanmill
