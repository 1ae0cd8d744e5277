#pragma once

// What a world says of its triangles, and how they stand, as shaders read it: arrays of 16-byte words.

#include <array>
#include <cstdint>
#include <vector>

#include "methods/world/world.h"

namespace scanmill {

using DeviceWord = std::array<std::uint32_t, 4>;

// The corners of a triangle (bits of float32, m, in the block's frame), and what stands behind each.
std::array<DeviceWord, 3> cornerWords(const TriangleBlock& block, std::uint32_t triangle,
                                      const std::array<std::uint32_t, 3>& behind);

// Two words of the plane (its normal's x, y, z and the offset in double), one of what the triangle says: the object
// (instance id where baked), class | material << 16, its index in its mesh, and 1 + its place among the textured
// triangles or 0.
struct TriangleRecord {
  DeviceWord normalXY, normalZOffset, label;
};

// Corners (bits of float32, m, in the block's frame) with u behind them; then v of all three.
struct TexturedTriangle {
  std::array<DeviceWord, 4> words;
};

constexpr std::uint32_t kLetsPass = 0x80000000u;  // of a texel; the other bits are its reflectance

// Why a material's texels are looked at.
constexpr std::uint32_t kTextured = 1;  // they scale the reflectance
constexpr std::uint32_t kCutOut = 2;    // some let beams pass

struct LabelTables {
  std::vector<TriangleRecord> records;     // of the baked block, then of those that worlds share
  std::vector<TexturedTriangle> textured;  // whose material's texels are looked at
  std::vector<DeviceWord> materials;  // bits of the reflectance, first texel, width | height << 16, kTextured | kCutOut
  std::vector<std::uint32_t> texels;  // bits of the reflectance (float32), kLetsPass
};

// What the texels of a scene's materials take, about.
std::uint64_t texelTableBytes(const Scene& scene);

// Throws Error where a texture is larger than 65535 texels a side.
LabelTables labelTables(const World& world);

// How a block stands: its first record (in LabelTables::records), the id of the mesh's first instance, and a Standing;
// then originFromMesh in rows of four doubles (linear part and translation), and as rows of the same length
// normalFromMesh or, where it moves, originFromMesh when the revolution ends.
enum class Standing : std::uint32_t { Baked, Placed, Moving };
struct Stand {
  DeviceWord head;
  std::array<DeviceWord, 12> rows;
};
static_assert(sizeof(Stand) == 13 * sizeof(DeviceWord));

// Of the baked block, then of World::placed.
std::vector<Stand> standsOf(const World& world);

}  // namespace scanmill
