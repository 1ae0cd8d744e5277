#pragma once

// A distance field around a sensor: how far it is to the nearest surface, finely near surfaces and near the sensor.
//
// Nested levels ("clipmaps", as in Unreal's global distance fields), each of twice the voxel size, or one level that
// holds the whole scene. A level is a box of bricks of 8 x 8 x 8 voxels. A brick near a surface keeps the distances at
// the 9 x 9 x 9 corners of its voxels; any other brick keeps one distance. Memory follows the surface, not the volume.
// Fields that move share bricks (brick_pool.h).
//
// Frames. "Lattice": corners of voxels have integer coordinates, counted from the world's origin (world.h) in voxels of
// the level; brick b holds corners 8b to 8b + 8 of each axis. The values at a corner follow from its place alone, not
// from the field that it is part of, so that a field that has moved holds the same bytes as one built anew.
// "Field": metres / voxel size of level 0, relative to the field's centre, in float32: the frame in which particles
// march.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/vec.h"

namespace scanmill {

constexpr int kBrickVoxels = 8;                     // per axis
constexpr int kHalfBrick = kBrickVoxels / 2;        // per axis
constexpr int kBrickCorners = kBrickVoxels + 1;     // per axis
constexpr int kCornersPerBrick = 9 * 9 * 9;         // x fastest, then y, then z
constexpr int kBrickStride = kCornersPerBrick + 1;  // of DistanceField::distance: even, two to a 32-bit word
constexpr float kDistanceStep = 1.0f / 2048;        // voxels, of the distances that bricks keep
constexpr std::uint32_t kNoWord = 0xFFFFFFFFu;      // of a corner that names no triangle: see DistanceField::word
constexpr std::uint32_t kFullBrick = 0x80000000u;   // of a table entry
constexpr std::uint32_t kLastOfList = 0x80000000u;  // of an entry of DistanceField::lists
constexpr std::uint32_t kMaxLevels = 16;

// All distances in voxels of the corner's level.
//
// A brick is empty where its centre is at least kEmptyBrick from all surfaces: every point of it is then at least
// kEmptyBrick - 4 sqrt(3) > 1 away. Distances of full bricks are never too large: they are exact up to kExact, and at
// least kExact where they are not, rounded to kDistanceStep.
constexpr float kEmptyBrick = 8.0f;
constexpr float kExact = 4.0f;
// Up to so far from a surface a corner names triangles: see DistanceField::word.
constexpr float kNamed = 2.0f;
// Up to so far from a surface a corner may have a list; beyond, nothing meets the voxel centred there, whose half
// diagonal is 0.8661.
constexpr float kListed = 0.93f;
// A list of a corner names all triangles that meet the cube which reaches so far around the corner. That is more than
// the voxel around it, since particles may take a place beside the voxel for one inside of it: they look kNudge
// (march_rule.h) past its faces, and as they know their place in metres in float32, they may be off by 3e-5 m a few
// hundred metres from the world's origin. Triangles farther behind them, up to kBehind, are in the lists of the voxels
// through which they came.
constexpr float kListedHalf = 0.55f;

using Corner = std::array<std::int64_t, 3>;  // or a brick: lattice coordinates

// Which bricks a level has.
struct LevelBox {
  Corner firstBrick{};
  std::array<std::uint32_t, 3> bricks{};

  std::uint64_t size() const { return std::uint64_t{bricks[0]} * bricks[1] * bricks[2]; }
  bool operator==(const LevelBox&) const = default;
};

// Where a field lies. Follows from the options and the sensor's place; see shape.h.
struct FieldShape {
  double voxel = 0.1;            // m, of level 0; level l: voxel * 2^l
  Vec3d centre;                  // m, relative to the world's origin; a corner of every brick grid of level 0
  std::vector<LevelBox> levels;  // finest first, 1 to kMaxLevels
  // Level l serves the points whose largest coordinate (field frame) is at most reach * 2^l; the last level serves all.
  float reach = 0;
  // Corners near surfaces name all triangles there, not the nearest one alone. On the street that takes 40 MB beside
  // 59, and of a million beams 28 get a wrong label, not 85,000.
  bool lists = false;

  bool operator==(const FieldShape&) const = default;
};

// What particles read of a level. A place q in the field frame lies at u = q * scale + offset, in voxels of the level
// from its first corner.
struct FieldLevel {
  std::array<float, 3> offset{};
  float scale = 1;  // 2^-level
  std::array<std::uint32_t, 3> bricks{};
  std::uint32_t firstEntry = 0;  // of its bricks in DistanceField::table; x fastest, then y, then z
};

struct BrickPool;  // brick_pool.h

// Read-only once built.
struct DistanceField {
  FieldShape shape;
  std::vector<FieldLevel> levels;
  // Per brick: kFullBrick + its index in the arrays below, or the bits of a float: the distance at the brick's centre,
  // voxels of its level (at least kEmptyBrick; rounded down).
  std::vector<std::uint32_t> table;
  // Per full brick kBrickStride values, of its corners, in kDistanceStep of a voxel.
  std::span<const std::uint16_t> distance;
  // Per full brick kBrickStride words, of its corners. Without lists: the nearest triangle. With lists: where the
  // corner's list begins in `lists`. kNoWord where the corner is farther than kNamed from all triangles; with lists,
  // where it is farther than kListed or its list is empty.
  std::span<const std::uint32_t> word;
  // Triangles that meet the cube around a corner (kListedHalf), in ascending order of (instance id, triangle), the last
  // marked by kLastOfList; in the order of corners. Were equal lists of neighbours shared, fields would be 4 % smaller
  // on the street and 7 % on truck_town.
  std::span<const std::uint32_t> lists;
  // Whose arrays these are, as far as they were there when the field was built. Where the field has moved there are
  // bricks among them that only fields before it had.
  std::shared_ptr<BrickPool> pool;
};

}  // namespace scanmill
