#pragma once

// A distance field around a sensor: distances to the nearest surface, with a finer resolution near surfaces and near
// the sensor.
//
// A field has nested levels ("clipmaps", as in Unreal's global distance fields). The voxels of a level are twice as
// large as those of the level before. A level is a box of bricks of 8 x 8 x 8 voxels. A brick near a surface stores the
// distances at the 9 x 9 x 9 corners of its voxels; any other brick stores one distance. Memory therefore grows with
// the surface area and not with the volume. The fields at the positions of a moving sensor share bricks (BrickPool).
//
// Two frames are used. In the "lattice", corners of voxels have integer coordinates, counted from the world's origin
// (world.h) in voxels of the level; brick b has the corners 8b to 8b + 8 along each axis. The values at a corner depend
// only on its position, so that a field that has moved has the same bytes as a new field at that position. Particles
// march in the "field frame": metres / voxel size of level 0, relative to the field's centre, in float32.

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "base/raw_vector.h"
#include "base/vec.h"

namespace scanmill {

constexpr int kBrickVoxels = 8;                     // voxels of a brick along each axis
constexpr int kHalfBrick = kBrickVoxels / 2;        // voxels of half a brick along each axis
constexpr int kBrickCorners = kBrickVoxels + 1;     // corners of voxels of a brick along each axis
constexpr int kCornersPerBrick = 9 * 9 * 9;         // corners of a brick; x runs fastest, then y, then z
constexpr int kBrickStride = kCornersPerBrick + 1;  // values per brick in DistanceField's arrays of corners; even,
                                                    // so that a brick's distances fill complete 32-bit words
constexpr float kDistanceStep = 1.0f / 2048;        // voxels, resolution of the distances in full bricks
constexpr std::uint32_t kNoTriangle = 0xFFFFFFFFu;  // in place of the index of a triangle or list: there is none
constexpr std::uint32_t kFullBrick = 0x80000000u;   // this bit of an entry of DistanceField::table marks a full brick
constexpr std::uint32_t kLastOfList = 0x80000000u;  // this bit of an entry of DistanceField::lists ends a list
constexpr std::uint32_t kMaxLevels = 16;

// All distances are in voxels of the corner's level. A brick is empty if its centre is at least kEmptyBrick from all
// surfaces; every point of the brick is then more than 1 voxel away (kEmptyBrick - 4 sqrt(3)). The distances
// in full bricks are never too large: exact up to kExactLimit, and otherwise lower bounds of at least kExactLimit. All
// are rounded down to multiples of kDistanceStep.
constexpr float kEmptyBrick = 8.0f;
constexpr float kExactLimit = 4.0f;
// Largest distance of a corner from a surface for which the corner has a triangle: see DistanceField::triangleOrList.
constexpr float kNearestLimit = 2.0f;
// Largest distance of a corner from a surface for which the corner may have a list. If a corner is farther away, no
// surface intersects the voxel centred at the corner: half of a voxel's diagonal is 0.8661.
constexpr float kListLimit = 0.93f;
// Half side of the cube around a corner. The corner's list contains all triangles that intersect the cube. The cube is
// larger than the voxel around the corner, because particles may test points slightly outside of the voxel: they look
// kFaceOvershoot (march_rule.h) past its faces, and their positions, metres in float32, may be off by 3e-5 m a few
// hundred metres from the world's origin. Triangles farther behind a particle, up to kBackwardTolerance, are in the
// lists of the voxels that the particle has passed.
constexpr float kListHalfSide = 0.55f;

using Corner = std::array<std::int64_t, 3>;  // lattice coordinates of a corner or a brick

// The bricks of a level, which form a box. The unit is a brick of the level.
struct LevelBox {
  Corner firstBrick{};
  std::array<std::uint32_t, 3> bricks{};

  std::uint64_t size() const { return std::uint64_t{bricks[0]} * bricks[1] * bricks[2]; }
  bool operator==(const LevelBox&) const = default;
};

// The position and extent of a field. shapeOf() in methods/particle/options.h computes both.
struct FieldShape {
  double voxel = 0.1;            // m, voxel size of level 0; level l has voxel * 2^l
  Vec3d centre;                  // m, relative to the world's origin; a corner of level 0's brick grid
  std::vector<LevelBox> levels;  // 1 to kMaxLevels levels, the finest first
  // Reach of level 0 (voxels). A point is looked up in the finest level l for which the point's largest absolute
  // coordinate (field frame) is at most reach * 2^l, or in the last level if the point is farther out.
  float reach = 0;
  // True: corners near surfaces store lists of all near triangles; false: only the nearest triangle. In "street" the
  // lists take 40 MB in addition to 59 MB, and reduce the wrong labels among a million beams from 85,000 to 28.
  bool lists = false;

  bool operator==(const FieldShape&) const = default;
};

// The data of a level that particles read. A point q in the field frame has the coordinates u = q * scale + offset, in
// voxels of the level from the level's first corner.
struct FieldLevel {
  std::array<float, 3> offset{};
  float scale = 1;  // 2^-level
  std::array<std::uint32_t, 3> bricks{};
  std::uint32_t firstEntry = 0;  // index in DistanceField::table of the level's first brick; x fastest, then y, then z
};

struct BrickPool;
struct World;  // methods/world/world.h

// A field is not modified after it is built.
struct DistanceField {
  FieldShape shape;
  std::vector<FieldLevel> levels;
  // One entry per brick. A full brick has kFullBrick + the brick's index in the arrays below. An empty brick has the
  // bits of a float, the centre's distance to surfaces (voxels of the level, rounded down, at least kEmptyBrick).
  std::vector<std::uint32_t> table;
  // kBrickStride values per full brick: the distances at its corners, in units of kDistanceStep voxels.
  std::span<const std::uint16_t> distance;
  // kBrickStride values per full brick, one per corner. In a field without lists: the nearest triangle, or kNoTriangle
  // if the corner is farther than kNearestLimit from all triangles. In a field with lists: the index in `lists` where
  // the corner's list begins, or kNoTriangle if the corner is farther than kListLimit or its list is empty.
  std::span<const std::uint32_t> triangleOrList;
  // The lists of corners, in the order of corners. A list contains the triangles that intersect the cube around its
  // corner (kListHalfSide), in ascending order of (instance id, triangle); its last entry has the bit kLastOfList.
  // Sharing equal lists between neighbouring corners would save only 4 % of a field in "street", 7 % in "truck_town".
  std::span<const std::uint32_t> lists;
  // The pool that owns these arrays. The spans above have the length that the arrays had when the field was built. If
  // the pool also belongs to earlier fields, the spans also contain bricks that only the earlier fields use.
  std::shared_ptr<BrickPool> pool;
};

// Returns the voxel size (m) of the level that is used at a point (field frame).
double voxelSizeAt(const DistanceField& field, const Vec3f& point);

// Returns the triangle, or kNoTriangle, that is stored at the corner nearest to a point (field frame). The field must
// have no lists.
std::uint32_t triangleAt(const DistanceField& field, const Vec3f& point);

// The bricks near surfaces ("full bricks") of a moving field. Fields at successive positions share a pool, so that
// their common bricks are stored once. A brick and its lists of triangles have a fixed index in the pool. Moving a
// field appends its new bricks, and a device that has the earlier bricks needs only the new bricks. If the pool is
// full, the field gets a new pool, to which the bricks that the field still needs are copied. The arrays are never
// reallocated, so that threads may read bricks while other bricks are appended.
struct BrickPool {
  // Reserves space for `capacity` bricks, and none for lists.
  explicit BrickPool(std::size_t capacity) {
    distance.resize(capacity * kBrickStride);
    triangleOrList.resize(capacity * kBrickStride);
    firstList.assign(capacity + 1, 0);
  }
  // Returns the number of bricks that can still be appended.
  std::size_t room() const { return firstList.size() - 1 - bricks; }

  // The arrays of DistanceField. The elements of the first `bricks` bricks are set.
  RawVector<std::uint16_t> distance;
  RawVector<std::uint32_t> triangleOrList;
  RawVector<std::uint32_t> lists;
  std::vector<std::uint32_t> firstList;  // index in `lists` of each brick's first list; entry `bricks`: the end

  std::mutex appending;  // locked while bricks are appended
  std::size_t bricks = 0;
};

// Returns the elements of DistanceField::levels for a field with this shape.
std::vector<FieldLevel> fieldLevels(const FieldShape& shape);

// Builds the field of a world, on all threads. Bricks of the fields in `before` are copied or shared (BrickPool) and
// not built again. All fields in `before` must belong to this world. A field in `before` is used only if it has the
// voxel size and the `lists` of `shape`, and the same pool as the first used field. The data that particles read is the
// same, byte by byte, for any `before` and any number of threads. The world must be flat, without instances. An empty
// world gives a field of empty bricks. Moving a field by a metre takes a thirtieth of the time of building it.
std::shared_ptr<const DistanceField> buildField(const World& world, const FieldShape& shape,
                                                const std::vector<std::shared_ptr<const DistanceField>>& before = {});

}  // namespace scanmill
