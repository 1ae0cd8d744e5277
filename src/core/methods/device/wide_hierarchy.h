#pragma once

// A hierarchy of boxes for compute shaders: nodes of up to eight children, whose boxes are counted in steps of a byte
// along each side (H. Ylitie, T. Karras, S. Laine, "Efficient incoherent ray traversal on GPUs through compressed wide
// BVHs", High Performance Graphics 2017, section 3).

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vec.h"
#include "methods/world/world.h"

namespace scanmill {

constexpr std::size_t kWideChildren = 8;
constexpr std::size_t kMostWideLeaf = 3;  // primitives of a leaf
// Of nodes from the root down, as shaders keep a stack of so many.
constexpr std::uint32_t kMostWideDepth = 32;

// As the shader reads it: five words of 16 bytes. Children sit in slots: bit 0, 1, 2 of a slot's number says that the
// child lies towards larger x, y, z of the node, so that a ray whose direction is negative along the axes of `signs`
// meets them nearest first in the order slot ^ signs = 0, 1, 2 ...
struct WideNode {
  std::array<float, 3> origin;           // m, of the children's boxes
  std::array<std::uint8_t, 3> exponent;  // a step along each axis is 2^(exponent - 127) m
  std::uint8_t inner;                    // bit k: in slot k is a node
  std::uint32_t firstNode;               // of those nodes, which follow each other in the order of their slots
  std::uint32_t firstPrimitive;          // of the leaves: a place in WideHierarchy::primitives
  // Of a leaf in slot k: bits 5 to 7 are as many ones as it has primitives, bits 0 to 4 say from which on, counted from
  // firstPrimitive. 0: empty. Of a node: 1.
  std::array<std::uint8_t, kWideChildren> leaf;
  std::array<std::array<std::uint8_t, kWideChildren>, 3> low, high;  // of the boxes, in steps from the origin
};
static_assert(sizeof(WideNode) == 80);

// About: three words of corners, and its share of the nodes; measured on the procedural street.
constexpr std::uint64_t kDeviceBytesPerTriangle = 64;

struct PrimitiveBox {
  Vec3f low, high;  // m
};

struct WideHierarchy {
  std::vector<WideNode> nodes;            // the first is the root; none where there are no primitives
  std::vector<std::uint32_t> primitives;  // their numbers, in the order of the leaves
};

// The lower and upper bound of a child's box along an axis, as the shader computes it: in float32, of which the product
// is exact, so that it does not matter whether the sum is fused.
float wideBound(const WideNode& node, std::size_t axis, std::uint8_t steps);

// Builds it with Embree's builder (rtcBuildBVH), by the surface area heuristic. Throws Error where memory is out, or
// where it would be deeper than kMostWideDepth.
WideHierarchy buildWideHierarchy(RTCDeviceTy* device, std::span<const PrimitiveBox> boxes);
// Of the triangles of a block.
WideHierarchy wideHierarchyOf(RTCDeviceTy* device, const TriangleBlock& block);

}  // namespace scanmill
