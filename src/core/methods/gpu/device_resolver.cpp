#include "methods/gpu/device_resolver.h"

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

// Offsets of the requested columns in the columns' buffer, in words of 4 bytes. Class and material share a column.
struct ColumnOffsets {
  ColumnOffsets(Channels channels, std::size_t rays) : end(rays) {
    // Returns the start of the next column, which has `words` words per ray if it is requested.
    const auto next = [&](bool requested, std::size_t words) {
      const std::size_t offset = end;
      if (requested) end += words * rays;
      return offset;
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

// Fills LabelTables::materials and LabelTables::texels. Materials that give the texels of a texture the same values
// share these texels.
class MaterialTables {
 public:
  explicit MaterialTables(LabelTables& tables) : tables_(tables) {}

  // Appends a material, and its texels unless an earlier material has equal texels.
  void append(const Material& material) {
    const CompactMaterial base = compact(material);
    const bool hasHoles = material.alphaTested && material.texture != nullptr;
    if (base.texture == nullptr && !hasHoles) {
      tables_.materials.push_back({bits(base.reflectance), 0, 0, 0});
      return;
    }
    const Texture& texture = *material.texture;
    constexpr std::uint32_t kMostTexels = 0xFFFF;  // texels along a side: a word contains both sizes, in 16 bits each
    if (texture.width > kMostTexels || texture.height > kMostTexels) {
      throw Error("the texture '{}' has more than {} texels per side, too many for a graphics card", texture.file,
                  kMostTexels);
    }
    const auto key = std::tuple(&texture, base.textureGain, base.reflectance, hasHoles ? material.alphaCutoff : -1.0f);
    const auto [firstTexel, isNew] = firstTexels_.emplace(key, static_cast<std::uint32_t>(tables_.texels.size()));
    if (isNew) appendTexels(material, base, hasHoles);
    tables_.materials.push_back({bits(base.reflectance), firstTexel->second, texture.width | texture.height << 16,
                                 (base.texture != nullptr ? kTextured : 0u) | (hasHoles ? kCutOut : 0u)});
  }

 private:
  void appendTexels(const Material& material, const CompactMaterial& base, bool hasHoles) {
    const Texture& texture = *material.texture;
    const std::size_t first = tables_.texels.size();
    const std::size_t count = std::size_t{texture.width} * texture.height;
    tables_.texels.resize(first + count);
    parallelForEach(count, kTableGrain, [&](std::size_t i) {
      const std::uint8_t* texel = &texture.rgba[4 * i];
      tables_.texels[first + i] = bits(base.texture != nullptr ? base.ofTexel(texel) : base.reflectance) |
                                  (hasHoles && letsPass(material, texel) ? kLetsPass : 0u);
    });
  }

  LabelTables& tables_;
  // Index of a texture's first texel. The key consists of the values on which the texels depend.
  std::map<std::tuple<const Texture*, float, float, float>, std::uint32_t> firstTexels_;
};

TexturedTriangle texturedTriangle(const TriangleBlock& block, std::uint32_t triangle) {
  TexturedTriangle textured{};
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t corner = block.corners[triangle][k];
    const Vec3f& p = block.vertices[corner];
    const Vec2f uv = block.uvs.empty() ? Vec2f{} : block.uvs[corner];
    textured.words[k] = {bits(p.x), bits(p.y), bits(p.z), bits(uv.x)};
    textured.words[3][k] = bits(uv.y);
  }
  return textured;
}

// Fills LabelTables::records and LabelTables::textured. The tables must have the materials already.
void addTriangles(const TriangleBlock& block, LabelTables& tables) {
  tables.records.resize(block.triangles.size());
  parallelForEach(block.triangles.size(), kTableGrain, [&](std::size_t t) {
    const BlockTriangle& triangle = block.triangles[t];
    const HitSurface& surface = block.surfaces[triangle.surface];
    tables.records[t] = {
        wordOf(triangle.normal.x, triangle.normal.y),
        wordOf(triangle.normal.z, triangle.offset),
        {surface.instance, surface.semantic | std::uint32_t{surface.material} << 16, triangle.primitive, 0}};
  });
  for (std::uint32_t t = 0; t < block.triangles.size(); ++t) {
    if (tables.materials[block.surfaceOf(t).material][3] == 0) continue;
    tables.textured.push_back(texturedTriangle(block, t));
    tables.records[t].label[3] = static_cast<std::uint32_t>(tables.textured.size());
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
  const ColumnOffsets offsets(hits.channels, piece.totalRays);
  std::mutex mutex;  // guards `unresolved`
  const std::size_t before = unresolved.size();
  parallelFor(piece.count, kTableGrain, [&](std::size_t begin, std::size_t end) {
    // If `channel` is not empty, copies rays [begin, end) of the piece from the column that starts at word `offset`.
    const auto copy = [&]<class T>(std::size_t offset, std::vector<T>& channel) {
      constexpr std::size_t kWords = sizeof(T) / 4;
      if (channel.empty()) return;
      std::memcpy(&channel[begin], columns.data() + 4 * (offset + kWords * (piece.firstRay + begin)),
                  sizeof(T) * (end - begin));
    };
    copy(0, hits.range);
    copy(offsets.incidence, hits.incidence);
    copy(offsets.reflectance, hits.reflectance);
    copy(offsets.instance, hits.instance);
    copy(offsets.primitive, hits.primitive);
    copy(offsets.normal, hits.normal);
    if (!hits.semantic.empty() || !hits.material.empty()) {
      for (std::size_t i = begin; i < end; ++i) {
        std::uint32_t label;  // class | material << 16
        std::memcpy(&label, columns.data() + 4 * (offsets.label + piece.firstRay + i), sizeof label);
        if (!hits.semantic.empty()) hits.semantic[i] = static_cast<std::uint16_t>(label);
        if (!hits.material.empty()) hits.material[i] = static_cast<std::uint16_t>(label >> 16);
      }
    }
    std::vector<UnresolvedRay> unresolvedOfTask;
    for (std::size_t i = begin; i < end; ++i) {
      if (!std::isnan(hits.range[i])) continue;
      unresolvedOfTask.push_back({static_cast<std::uint32_t>(i), std::bit_cast<UnresolvedReason>(hits.range[i])});
    }
    if (unresolvedOfTask.empty()) return;
    const std::scoped_lock lock(mutex);
    unresolved.insert(unresolved.end(), unresolvedOfTask.begin(), unresolvedOfTask.end());
  });
  std::ranges::sort(unresolved.begin() + static_cast<std::ptrdiff_t>(before), unresolved.end(), {},
                    &UnresolvedRay::ray);
}

LabelTables labelTables(const World& world) {
  LabelTables tables;
  MaterialTables materials(tables);
  for (const Material& material : world.scene->materials) materials.append(material);
  addTriangles(world.baked, tables);
  return tables;
}

}  // namespace scanmill
