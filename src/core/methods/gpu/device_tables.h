#pragma once

// Tables of a flat world's triangles, materials and texels, as shaders read them: arrays of 16-byte words.

#include <array>
#include <cstdint>
#include <vector>

#include "methods/world/world.h"

namespace scanmill {

using DeviceWord = std::array<std::uint32_t, 4>;

// Two words for the plane (the normal's x, y, z and the offset, in double) and one for the labels: the instance id,
// class | material << 16, the triangle's index in its mesh, and 1 + its index in LabelTables::textured, or 0 if it is
// not textured.
struct TriangleRecord {
  DeviceWord normalXY, normalZOffset, label;
};

// Three words, each with a corner (bits of float32, m, relative to the world's origin) and its texture coordinate u;
// then one word with the three texture coordinates v.
struct TexturedTriangle {
  std::array<DeviceWord, 4> words;
};

constexpr std::uint32_t kLetsPass = 0x80000000u;  // bit of a transparent texel; the other bits are the reflectance

// Flags of a material: the reasons why its texels are read.
constexpr std::uint32_t kTextured = 1;  // texels scale the reflectance
constexpr std::uint32_t kCutOut = 2;    // some texels may let beams pass

struct LabelTables {
  std::vector<TriangleRecord> records;     // one per triangle of World::baked
  std::vector<TexturedTriangle> textured;  // triangles whose material's texels are read
  // One entry per material: bits of its reflectance, index of its first texel, width | height << 16 of its texture,
  // flags.
  std::vector<DeviceWord> materials;
  std::vector<std::uint32_t> texels;  // bits of the reflectance (float32), with kLetsPass if transparent
};

// Returns approximately how many bytes the texels of a scene's materials take.
std::uint64_t texelTableBytes(const Scene& scene);

// Returns the tables of a flat world, in which nothing is instanced. Throws Error if a texture has more than 65535
// texels along a side.
LabelTables labelTables(const World& world);

}  // namespace scanmill
