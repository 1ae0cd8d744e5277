#include "methods/gpu/device_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <map>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "scene/reflectance.h"
#include "scene/texture.h"

namespace scanmill {

namespace {

constexpr std::size_t kTableGrain = 16384;

std::uint32_t bits(float f) {
  return std::bit_cast<std::uint32_t>(f);
}

DeviceWord wordOf(double a, double b) {
  return std::bit_cast<DeviceWord>(std::array{a, b});
}

// Creates the words of materials, and the texels of their textures. Materials that give the texels of a texture the
// same values share these texels.
class MaterialTables {
 public:
  explicit MaterialTables(LabelTables& made) : made_(made) {}

  void append(const Material& material) {
    const CompactMaterial base = compact(material);
    const bool cut = material.alphaTested && material.texture != nullptr;
    if (base.texture == nullptr && !cut) {
      made_.materials.push_back({bits(base.reflectance), 0, 0, 0});
      return;
    }
    const Texture& texture = *material.texture;
    constexpr std::uint32_t kMost = 0xFFFF;
    if (texture.width > kMost || texture.height > kMost) {
      throw Error(fmt::format("the texture '{}' has more than {} texels per side, too many for a graphics card",
                              texture.file, kMost));
    }
    const auto key = std::tuple(&texture, base.textureGain, base.reflectance, cut ? material.alphaCutoff : -1.0f);
    const auto [known, added] = firstOf_.emplace(key, static_cast<std::uint32_t>(made_.texels.size()));
    if (added) appendTexels(material, base, cut);
    made_.materials.push_back({bits(base.reflectance), known->second, texture.width | texture.height << 16,
                               (base.texture != nullptr ? kTextured : 0u) | (cut ? kCutOut : 0u)});
  }

 private:
  void appendTexels(const Material& material, const CompactMaterial& base, bool cut) {
    const Texture& texture = *material.texture;
    const std::size_t first = made_.texels.size();
    const std::size_t count = std::size_t{texture.width} * texture.height;
    made_.texels.resize(first + count);
    parallelFor(count, kTableGrain, [&](std::size_t from, std::size_t to) {
      for (std::size_t i = from; i < to; ++i) {
        const std::uint8_t* texel = &texture.rgba[4 * i];
        made_.texels[first + i] = bits(base.texture != nullptr ? base.ofTexel(texel) : base.reflectance) |
                                  (cut && letsPass(material, texel) ? kLetsPass : 0u);
      }
    });
  }

  LabelTables& made_;
  std::map<std::tuple<const Texture*, float, float, float>, std::uint32_t> firstOf_;
};

TexturedTriangle texturedTriangle(const TriangleBlock& block, std::uint32_t triangle) {
  TexturedTriangle made{};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t corner = block.corners[triangle][k];
    const Vec3f& p = block.vertices[corner];
    const Vec2f uv = block.uvs.empty() ? Vec2f{} : block.uvs[corner];
    made.words[k] = {bits(p.x), bits(p.y), bits(p.z), bits(uv.x)};
    made.words[3][k] = bits(uv.y);
  }
  return made;
}

void addTriangles(const TriangleBlock& block, LabelTables& made) {
  made.records.resize(block.triangles.size());
  parallelFor(block.triangles.size(), kTableGrain, [&](std::size_t from, std::size_t to) {
    for (std::size_t t = from; t < to; ++t) {
      const BlockTriangle& triangle = block.triangles[t];
      const HitSurface& surface = block.surfaces[triangle.surface];
      made.records[t] = {
          wordOf(triangle.normal.x, triangle.normal.y),
          wordOf(triangle.normal.z, triangle.offset),
          {surface.instance, surface.semantic | std::uint32_t{surface.material} << 16, triangle.primitive, 0}};
    }
  });
  for (std::uint32_t t = 0; t < block.triangles.size(); ++t) {
    if (made.materials[block.surfaceOf(t).material][3] == 0) continue;
    made.textured.push_back(texturedTriangle(block, t));
    made.records[t].label[3] = static_cast<std::uint32_t>(made.textured.size());
  }
}

}  // namespace

std::uint64_t texelTableBytes(const Scene& scene) {
  std::map<std::pair<const Texture*, float>, std::uint64_t> bytes;
  for (const Material& material : scene.materials) {
    const Texture* texture = material.texture.get();
    if (texture == nullptr || !(material.alphaTested || material.textured)) continue;
    bytes[{texture, material.reflectance}] = std::uint64_t{4} * texture->width * texture->height;
  }
  std::uint64_t sum = 0;
  for (const auto& [key, each] : bytes) sum += each;
  return sum;
}

LabelTables labelTables(const World& world) {
  LabelTables made;
  MaterialTables materials(made);
  for (const Material& material : world.scene->materials) materials.append(material);
  addTriangles(world.baked, made);
  return made;
}

}  // namespace scanmill
