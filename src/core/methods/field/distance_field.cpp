#include "methods/field/distance_field.h"

#include <algorithm>
#include <cmath>

namespace scanmill {

namespace {

// Returns the level that is used at a point: the smallest l with |coordinates| <= reach * 2^l, or the last level.
int levelAt(const DistanceField& field, const Vec3f& point) {
  const float largest = std::max({std::fabs(point.x), std::fabs(point.y), std::fabs(point.z)});
  const int lastLevel = static_cast<int>(field.levels.size()) - 1;
  int level = 0;
  for (float reach = field.shape.reach; level < lastLevel && largest > reach; reach *= 2) ++level;
  return level;
}

struct VoxelPosition {
  std::uint32_t brick;                 // entry of DistanceField::table
  std::array<std::uint32_t, 3> voxel;  // coordinates of the voxel in the brick
  std::array<float, 3> inVoxel;        // position in the voxel, 0 to 1
};

VoxelPosition voxelAt(const DistanceField& field, const Vec3f& point) {
  const FieldLevel& level = field.levels[static_cast<std::size_t>(levelAt(field, point))];
  const float coordinates[3] = {point.x, point.y, point.z};
  VoxelPosition position{};
  std::uint32_t entry = level.firstEntry;
  std::uint32_t stride = 1;  // in the table, from brick to brick along axis k
  for (std::size_t k = 0; k < 3; ++k) {
    const float u = std::max(coordinates[k] * level.scale + level.offset[k], 0.0f);
    const std::uint32_t corner = std::min(static_cast<std::uint32_t>(u), level.bricks[k] * kBrickVoxels - 1);
    position.voxel[k] = corner % kBrickVoxels;
    position.inVoxel[k] = u - static_cast<float>(corner);
    entry += corner / kBrickVoxels * stride;
    stride *= level.bricks[k];
  }
  position.brick = field.table[entry];
  return position;
}

// Returns the index of a corner in the arrays of full bricks. `brick`: the brick's table entry; x, y, z: the corner in
// the brick.
std::size_t cornerIndex(std::uint32_t brick, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return std::size_t{brick - kFullBrick} * kBrickStride + (z * kBrickCorners + y) * kBrickCorners + x;
}

}  // namespace

double voxelSizeAt(const DistanceField& field, const Vec3f& point) {
  return std::ldexp(field.shape.voxel, levelAt(field, point));
}

std::uint32_t triangleAt(const DistanceField& field, const Vec3f& point) {
  const VoxelPosition position = voxelAt(field, point);
  if (position.brick < kFullBrick) return kNoTriangle;
  const auto nearest = [&](std::size_t k) { return position.voxel[k] + (position.inVoxel[k] >= 0.5f ? 1 : 0); };
  return field.triangleOrList[cornerIndex(position.brick, nearest(0), nearest(1), nearest(2))];
}

}  // namespace scanmill
