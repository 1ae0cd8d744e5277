#include "methods/gpu/device_resolver.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>
#include <tuple>

#include "base/error.h"
#include "base/parallel.h"
#include "methods/world/resolve.h"
#include "scene/reflectance.h"

namespace scanmill {

namespace {

using enum ComputeTable::Texel;

std::uint32_t bitsOf(Channels channels) {
  std::uint32_t set = 0;
  for (const ChannelRow& row : kChannels)
    set |= channels.has(row.channel) ? static_cast<std::uint32_t>(row.channel) : 0u;
  return set;
}

static_assert(kChannels.size() == 8, "say in ColumnOffsets and copyHits() where the new channel is");

// Starts of the requested columns, in words of 4 bytes. Class and material share a column.
struct ColumnOffsets {
  ColumnOffsets(Channels channels, std::size_t rays) : end(rays) {
    const auto next = [&](bool requested, std::size_t words) {
      const std::size_t at = end;
      if (requested) end += words * rays;
      return at;
    };
    incidence = next(channels.has(Channel::Incidence), 1);
    reflectance = next(channels.has(Channel::Reflectance), 1);
    instance = next(channels.has(Channel::Instance), 1);
    label = next(channels.has(Channel::Semantic) || channels.has(Channel::Material), 1);
    primitive = next(channels.has(Channel::Primitive), 1);
    normal = next(channels.has(Channel::Normal), 3);
  }
  std::size_t end;  // total length of the columns; the range is the first column and begins at 0
  std::size_t incidence, reflectance, instance, label, primitive, normal;
};

constexpr std::size_t kTableGrain = 16384;  // triangles, texels or rays per task

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

DeviceResolver::DeviceResolver(const ComputeDevice& device)
    : device_(device),
      columns_(device),
      records_(device),
      materials_(device),
      reflectances_(device),
      textured_(device) {}

void DeviceResolver::uploadMeshes(const World& world) {
  const LabelTables tables = labelTables(world);
  const auto upload = [&](ComputeBuffer& buffer, ComputeTable::Texel texel, const auto& array, const char* what) {
    uploadTable(device_, buffer, texel, std::as_bytes(std::span(array)), what);
  };
  upload(records_, Uint32x4, tables.records, "scene's planes and labels");
  upload(textured_, Uint32x4, tables.textured, "scene's textured triangles");
  upload(materials_, Uint32x4, tables.materials, "scene's materials");
  upload(reflectances_, Uint32, tables.texels, "scene's textures");
}

ResolverParameters DeviceResolver::parameters(const BeamTable& beams, Channels channels, std::size_t rays) {
  const RangeLimits limits = limitsOf(beams);
  return {limits.nearest, limits.farthest, bitsOf(channels), static_cast<std::uint32_t>(rays)};
}

std::uint64_t DeviceResolver::bytesPerRay(Channels channels) {
  return ColumnOffsets(channels, 1).end * sizeof(std::uint32_t);
}

void DeviceResolver::reserve(Channels channels, std::size_t rays) {
  columns_.reserve(bytesPerRay(channels) * rays);
}

ComputeTable DeviceResolver::table(std::size_t binding) const {
  const std::array<const ComputeBuffer*, kTables> buffers{&records_, &materials_, &reflectances_, &textured_};
  return {buffers[binding], binding == 2 ? Uint32 : Uint32x4};
}

void DeviceResolver::copyHits(std::span<const std::byte> columns, const Piece& piece, Hits& hits,
                              std::vector<UnresolvedRay>& unresolved) {
  const ColumnOffsets places(hits.channels, piece.all);
  std::mutex mutex;
  const std::size_t before = unresolved.size();
  parallelFor(piece.count, kTableGrain, [&](std::size_t from, std::size_t to) {
    const auto copy = [&](std::size_t word, std::size_t words, auto* values) {
      std::memcpy(values, columns.data() + 4 * (word + words * (piece.from + from)), 4 * words * (to - from));
    };
    copy(0, 1, &hits.range[from]);
    if (!hits.incidence.empty()) copy(places.incidence, 1, &hits.incidence[from]);
    if (!hits.reflectance.empty()) copy(places.reflectance, 1, &hits.reflectance[from]);
    if (!hits.instance.empty()) copy(places.instance, 1, &hits.instance[from]);
    if (!hits.primitive.empty()) copy(places.primitive, 1, &hits.primitive[from]);
    if (!hits.normal.empty()) copy(places.normal, 3, &hits.normal[from]);
    if (!hits.semantic.empty() || !hits.material.empty()) {
      std::array<std::uint32_t, 256> labels;
      for (std::size_t i = from; i < to; i += labels.size()) {
        const std::size_t some = std::min(labels.size(), to - i);
        std::memcpy(labels.data(), columns.data() + 4 * (places.label + piece.from + i), 4 * some);
        for (std::size_t k = 0; k < some && !hits.semantic.empty(); ++k)
          hits.semantic[i + k] = static_cast<std::uint16_t>(labels[k]);
        for (std::size_t k = 0; k < some && !hits.material.empty(); ++k)
          hits.material[i + k] = static_cast<std::uint16_t>(labels[k] >> 16);
      }
    }
    std::vector<UnresolvedRay> mine;
    for (std::size_t i = from; i < to; ++i) {
      if (!std::isnan(hits.range[i])) continue;
      mine.push_back({static_cast<std::uint32_t>(i), std::bit_cast<UnresolvedReason>(hits.range[i])});
    }
    if (mine.empty()) return;
    const std::scoped_lock lock(mutex);
    unresolved.insert(unresolved.end(), mine.begin(), mine.end());
  });
  std::sort(unresolved.begin() + static_cast<std::ptrdiff_t>(before), unresolved.end(),
            [](const UnresolvedRay& a, const UnresolvedRay& b) { return a.ray < b.ray; });
}

LabelTables labelTables(const World& world) {
  LabelTables made;
  MaterialTables materials(made);
  for (const Material& material : world.scene->materials) materials.append(material);
  addTriangles(world.baked, made);
  return made;
}

}  // namespace scanmill
