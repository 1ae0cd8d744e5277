#include "methods/ray_tracing/device_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "base/error.h"
#include "base/parallel.h"
#include "scene/reflectance.h"

namespace scanmill {

namespace {

constexpr std::size_t kGrain = 16384;

std::uint32_t bits(float f) {
  return std::bit_cast<std::uint32_t>(f);
}

std::uint32_t bits(double d) {
  return bits(static_cast<float>(d));
}

// Adds hierarchies to those that are there.
void append(std::vector<WideNode>& nodes, WideHierarchy hierarchy, std::uint32_t firstPrimitive) {
  const auto first = static_cast<std::uint32_t>(nodes.size());
  for (WideNode& node : hierarchy.nodes) {
    node.firstNode += first;
    node.firstPrimitive += firstPrimitive;
  }
  nodes.insert(nodes.end(), hierarchy.nodes.begin(), hierarchy.nodes.end());
}

// The cut-outs of materials, each once.
class Holes {
 public:
  Holes(const Scene& scene, std::vector<std::uint32_t>& words) : scene_(scene), words_(words) {}

  // Width | height << 16 of a material's texture, and the first of its words.
  std::pair<std::uint32_t, std::uint32_t> of(std::uint16_t number) {
    const Material& material = scene_.materials[number];
    const Texture& texture = *material.texture;
    constexpr std::uint32_t kMost = 0xFFFF;
    if (texture.width > kMost || texture.height > kMost) {
      throw Error(
          fmt::format("'{}' has more than {} texels a side, too many for a graphics card", texture.file, kMost));
    }
    const std::uint32_t size = texture.width | texture.height << 16;
    const auto [known, added] = firstOf_.emplace(number, static_cast<std::uint32_t>(words_.size()));
    if (!added) return {size, known->second};
    const std::size_t texels = std::size_t{texture.width} * texture.height;
    words_.resize(words_.size() + (texels + 31) / 32);
    for (std::size_t i = 0; i < texels; ++i) {
      if (letsPass(material, &texture.rgba[4 * i])) words_[known->second + i / 32] |= 1u << i % 32;
    }
    return {size, known->second};
  }

 private:
  const Scene& scene_;
  std::vector<std::uint32_t>& words_;
  std::map<std::uint16_t, std::uint32_t> firstOf_;  // by material
};

void appendCutouts(const TriangleBlock& block, Holes& holes, std::vector<DeviceWord>& cutouts) {
  for (auto t = block.firstAlpha; t < block.triangles.size(); ++t) {
    const Triangle& corners = block.corners[t];
    std::array<Vec2f, 3> uv{};
    for (std::size_t k = 0; k < 3 && !block.uvs.empty(); ++k) uv[k] = block.uvs[corners[k]];
    const auto [size, first] = holes.of(block.surfaceOf(t).material);
    cutouts.push_back({bits(uv[0].x), bits(uv[0].y), bits(uv[1].x), bits(uv[1].y)});
    cutouts.push_back({bits(uv[2].x), bits(uv[2].y), size, first});
  }
}

void appendBlock(RTCDeviceTy* device, const TriangleBlock& block, Holes& holes, DeviceMeshes& made) {
  WideHierarchy hierarchy = wideHierarchyOf(device, block);
  const std::size_t firstTriangle = made.triangles.size() / 3;
  const std::size_t firstCutout = made.cutouts.size() / 2;
  made.triangles.resize(made.triangles.size() + 3 * hierarchy.primitives.size());
  parallelFor(hierarchy.primitives.size(), kGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const std::uint32_t t = hierarchy.primitives[i];
      const bool cut = t >= block.firstAlpha;
      const auto cutout = static_cast<std::uint32_t>(cut ? firstCutout + t - block.firstAlpha + 1 : 0);
      std::ranges::copy(cornerWords(block, t, {t, cutout, 0}), &made.triangles[3 * (firstTriangle + i)]);
    }
  });
  appendCutouts(block, holes, made.cutouts);
  DeviceBlock& known = made.blocks[&block];
  known.root = static_cast<std::uint32_t>(made.nodes.size());
  for (const Vec3f& p : std::span(block.vertices).first(block.vertices.size() - 1)) known.box.add(Vec3d(p));
  append(made.nodes, std::move(hierarchy), static_cast<std::uint32_t>(firstTriangle));
}

PrimitiveBox placedBox(const PlacedBlock& placed, const Box& mesh) {
  Box box;
  double largest = 1;                     // m, of what is rounded: the shader's rays on their way into the mesh's frame
  for (const double part : {0.0, 1.0}) {  // between them corners move along straight lines
    const Affine place = placed.at(part);
    const double corners = std::max(length(mesh.low), length(mesh.high));
    const double scale = length(place.linear.x) + length(place.linear.y) + length(place.linear.z);
    largest = std::max(largest, length(place.translation) + corners * scale);
    for (int corner = 0; corner < 8; ++corner) {
      box.add(place * Vec3d{corner & 1 ? mesh.high.x : mesh.low.x, corner & 2 ? mesh.high.y : mesh.low.y,
                            corner & 4 ? mesh.high.z : mesh.low.z});
    }
  }
  constexpr double kRounding = 4e-6;
  const double slack = kRounding * std::max({length(box.low), length(box.high), largest});
  return {Vec3f(box.low - Vec3d{slack, slack, slack}), Vec3f(box.high + Vec3d{slack, slack, slack})};
}

// The baked block and those that worlds share, placed in this one or not, as far as they hold triangles.
std::vector<const TriangleBlock*> blocksOf(const World& world) {
  std::vector<const TriangleBlock*> blocks;
  if (!world.baked.triangles.empty()) blocks.push_back(&world.baked);
  for (const std::unique_ptr<TriangleBlock>& block : world.shared->blocks) {
    if (block != nullptr && !block->triangles.empty()) blocks.push_back(block.get());
  }
  return blocks;
}

std::array<DeviceWord, 3> rowsOf(const Affine& a) {
  const auto row = [&](double Vec3d::*axis) {
    return DeviceWord{bits(a.linear.x.*axis), bits(a.linear.y.*axis), bits(a.linear.z.*axis),
                      bits(a.translation.*axis)};
  };
  return {row(&Vec3d::x), row(&Vec3d::y), row(&Vec3d::z)};
}

}  // namespace

DeviceMeshes deviceMeshes(RTCDeviceTy* device, const World& world) {
  DeviceMeshes made;
  Holes holes(*world.scene, made.holes);
  for (const TriangleBlock* block : blocksOf(world)) appendBlock(device, *block, holes, made);
  return made;
}

DevicePlaces devicePlaces(RTCDeviceTy* device, const World& world, const DeviceBlocks& blocks) {
  std::vector<PrimitiveBox> boxes;
  std::vector<std::uint32_t> numbers;  // into World::placed
  for (std::uint32_t k = 0; k < world.placed.size(); ++k) {
    const auto block = blocks.find(world.placed[k].block);
    if (block == blocks.end()) continue;  // it has no triangles
    boxes.push_back(placedBox(world.placed[k], block->second.box));
    numbers.push_back(k);
  }
  WideHierarchy hierarchy = buildWideHierarchy(device, boxes);
  DevicePlaces made;
  made.places.reserve(DevicePlaces::kWords * numbers.size());
  for (const std::uint32_t primitive : hierarchy.primitives) {
    const std::uint32_t k = numbers[primitive];
    const PlacedBlock& placed = world.placed[k];
    const std::array<DeviceWord, 3> first =
        rowsOf(placed.moves ? placed.originFromMesh : inverse(placed.originFromMesh));
    std::array<DeviceWord, 3> last{};
    if (placed.moves) {
      last = rowsOf(placed.atEnd);
    } else {
      const Vec3d& stands = placed.originFromMesh.translation;
      last[0] = {bits(stands.x), bits(stands.y), bits(stands.z), 0};
    }
    made.places.insert(made.places.end(), first.begin(), first.end());
    made.places.insert(made.places.end(), last.begin(), last.end());
    made.places.push_back({blocks.at(placed.block).root, k, placed.moves ? 1u : 0u, 0});
  }
  append(made.nodes, std::move(hierarchy), 0);
  return made;
}

}  // namespace scanmill
