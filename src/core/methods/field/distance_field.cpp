#include "methods/field/distance_field.h"

#include <algorithm>
#include <cmath>

namespace scanmill {

namespace {

// Returns the level that is used at a point: the smallest l with |coordinates| <= reach * 2^l, or the last level.
int levelAt(const DistanceField& field, const Vec3f& place) {
  const float most = std::max({std::fabs(place.x), std::fabs(place.y), std::fabs(place.z)});
  const int last = static_cast<int>(field.levels.size()) - 1;
  int level = 0;
  for (float reach = field.shape.reach; level < last && most > reach; reach *= 2) ++level;
  return level;
}

struct FieldPlace {
  std::uint32_t brick;              // value from DistanceField::table
  std::array<std::uint32_t, 3> in;  // voxel within the brick
  std::array<float, 3> f;           // position within the voxel, 0 to 1
};

FieldPlace placeIn(const DistanceField& field, const Vec3f& place) {
  const FieldLevel& level = field.levels[static_cast<std::size_t>(levelAt(field, place))];
  const float q[3] = {place.x, place.y, place.z};
  FieldPlace found{};
  std::uint32_t entry = level.firstEntry;
  std::uint32_t bricks = 1;
  for (std::size_t k = 0; k < 3; ++k) {
    const float u = std::max(q[k] * level.scale + level.offset[k], 0.0f);
    const std::uint32_t corner = std::min(static_cast<std::uint32_t>(u), level.bricks[k] * kBrickVoxels - 1);
    found.in[k] = corner % kBrickVoxels;
    found.f[k] = u - static_cast<float>(corner);
    entry += corner / kBrickVoxels * bricks;
    bricks *= level.bricks[k];
  }
  found.brick = field.table[entry];
  return found;
}

// Returns the index of a corner in the arrays of full bricks. `brick`: the brick's table entry; x, y, z: the corner in
// the brick.
std::size_t cornerIndex(std::uint32_t brick, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return std::size_t{brick - kFullBrick} * kBrickStride + (z * kBrickCorners + y) * kBrickCorners + x;
}

}  // namespace

double voxelSizeAt(const DistanceField& field, const Vec3f& place) {
  return std::ldexp(field.shape.voxel, levelAt(field, place));
}

std::uint32_t triangleAt(const DistanceField& field, const Vec3f& place) {
  const FieldPlace at = placeIn(field, place);
  if (at.brick < kFullBrick) return kNoWord;
  const auto nearest = [&](std::size_t k) { return at.in[k] + (at.f[k] >= 0.5f ? 1 : 0); };
  return field.word[cornerIndex(at.brick, nearest(0), nearest(1), nearest(2))];
}

}  // namespace scanmill
