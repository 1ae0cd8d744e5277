#pragma once

// Tables of a flat world's triangles, materials and texels, as shaders read them: arrays of 16-byte words.

#include <array>
#include <cstdint>
#include <vector>

#include "methods/world/world.h"

namespace scanmill {

using DeviceWord = std::array<std::uint32_t, 4>;

// Two words of the plane (its normal's x, y, z and the offset in double), one of what the triangle says: the
// instance id, class | material << 16, its index in its mesh, and 1 + its place among the textured
// triangles or 0.
struct TriangleRecord {
  DeviceWord normalXY, normalZOffset, label;
};

// Corners (bits of float32, m, relative to the world's origin) with u behind them; then v of all three.
struct TexturedTriangle {
  std::array<DeviceWord, 4> words;
};

constexpr std::uint32_t kLetsPass = 0x80000000u;  // of a texel; the other bits are its reflectance

// Why a material's texels are looked at.
constexpr std::uint32_t kTextured = 1;  // they scale the reflectance
constexpr std::uint32_t kCutOut = 2;    // some let beams pass

struct LabelTables {
  std::vector<TriangleRecord> records;     // of World::baked
  std::vector<TexturedTriangle> textured;  // whose material's texels are looked at
  std::vector<DeviceWord> materials;  // bits of the reflectance, first texel, width | height << 16, kTextured | kCutOut
  std::vector<std::uint32_t> texels;  // bits of the reflectance (float32), kLetsPass
};

// What the texels of a scene's materials take, about.
std::uint64_t texelTableBytes(const Scene& scene);

// Throws Error where a texture is larger than 65535 texels a side. Nothing of the world may be instanced.
LabelTables labelTables(const World& world);

}  // namespace scanmill
