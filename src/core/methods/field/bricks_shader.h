#pragma once

// The compute programs that make bricks; see gpu/compute.h. What they make has the bits that BrickMaker and
// nearestFacet() make on the processor: sums and products are `precise`, quotients and roots are corrected until they
// are rounded as IEEE 754 rounds them. Where numbers are so small that a device may take them for nothing, the brick is
// left to the processor.
//
// Storage buffer 0: places of bricks (BrickPlaceWords each). Tables: 0 the nodes of a WideHierarchy, 1 its triangles in
// the order of its leaves, three words each: corners (bits of float32, m, relative to the world's origin), and behind
// the first the triangle's place in the order in which equally near ones come.

#include <array>
#include <cstdint>
#include <string>

#include "methods/field/distance_field.h"

namespace scanmill {

// Centre (m), voxel (m), and voxels a metre.
using BrickPlaceWords = std::array<double, 5>;

constexpr std::uint32_t kBlocksPerBrick = 27;
constexpr std::uint32_t kLeftBrick = 0xFFFFFFFFu;  // in the place of a distance: the processor makes the brick

// An invocation a brick. Storage buffer 1: bits of the distance of each brick's centre as the field's table has it, or
// kLeftBrick.
std::string brickCentresShader();

// An invocation a block (brick.h). Storage buffer 1: bits of the distance of each block's centre, up to where triangles
// are looked at; or kLeftBrick.
std::string brickBlocksShader();

// kCornersPerBrick invocations a brick. Storage buffers: 1 what brickBlocksShader() made, 2 two words a corner: its
// distance in kDistanceStep, or kLeftBrick, and the nearest triangle or kNoWord.
std::string brickCornersShader();

// Likewise, of the triangles that meet the cubes around corners. Storage buffers: 1 two words a corner, of which the
// first is the distance; the second becomes the number of triangles. 2: nothing.
std::string brickCountsShader();
// 1: two words a corner; of those that have triangles the second says where they begin in 2, in which they are written:
// in order, where they are no more than kMostSorted. One invocation takes too long to sort more.
constexpr std::uint32_t kMostSorted = 64;
std::string brickListsShader();

}  // namespace scanmill
