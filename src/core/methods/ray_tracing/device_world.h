#pragma once

// A world as the compute shader of ray tracing reads it: hierarchies of triangles and of placed meshes, in arrays of
// 16-byte words. Indices are of whole arrays.

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "methods/device/device_tables.h"
#include "methods/device/wide_hierarchy.h"
#include "methods/world/world.h"

namespace scanmill {

constexpr std::uint32_t kNoRoot = 0xFFFFFFFFu;

// Where the hierarchies of blocks are.
struct DeviceBlock {
  std::uint32_t root = 0;
  Box box;  // m, in the block's frame
};
using DeviceBlocks = std::map<const TriangleBlock*, DeviceBlock>;

// The triangles of some blocks.
struct DeviceMeshes {
  std::vector<WideNode> nodes;
  // Three words a triangle, in the order of the hierarchies' leaves: its corners (bits of float32, m, in the block's
  // frame), and behind them its number in the block, and 1 + its place in `cutouts` / 2, or 0 where it is opaque.
  std::vector<DeviceWord> triangles;
  // Two words for each alpha-tested triangle: the bits of its texture coordinates u, v of three corners, the texture's
  // width | height << 16, and the first of its words in `holes`.
  std::vector<DeviceWord> cutouts;
  std::vector<std::uint32_t> holes;  // a bit a texel, row by row, lowest bit first: beams pass
  DeviceBlocks blocks;
};

// The meshes that are placed, and how they stand.
struct DevicePlaces {
  static constexpr std::size_t kWords = 7;
  std::vector<WideNode> nodes;  // of boxes around placed meshes, where they are during the revolution
  // In the order of the leaves, kWords words each. Of what stands still: the rows of meshFromOrigin (bits of float32:
  // linear part and translation), where it stands (m), and two words of nothing; of what moves: the rows of
  // originFromMesh when the revolution starts, and when it ends. Then the mesh's root, its place in World::placed, and
  // whether it moves.
  std::vector<DeviceWord> places;
};

// Throws Error where memory is out or a texture is larger than 65535 texels a side.
DeviceMeshes deviceMeshes(RTCDeviceTy* device, const World& world);
DevicePlaces devicePlaces(RTCDeviceTy* device, const World& world, const DeviceBlocks& blocks);

}  // namespace scanmill
