#include "scene/voxel_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

namespace scanmill {
namespace {

TEST(VoxelGrid, IsSemanticKittisByDefault) {
  const VoxelGrid grid;
  EXPECT_EQ(grid.voxels(), 256u * 256 * 32);
  EXPECT_EQ(grid.index(0, 0, 1), 1u);
  EXPECT_EQ(grid.index(0, 1, 0), 32u);
  EXPECT_EQ(grid.index(1, 0, 0), 256u * 32);
  EXPECT_EQ(grid.at({0.1, -25.5, -1.9}), 0u);
  EXPECT_EQ(grid.at({51.1, 25.5, 4.3}), grid.voxels() - 1);
  EXPECT_EQ(grid.at({0.1, 0.1, 0.1}), grid.index(0, 128, 10));
  for (const Vec3d& outside : {Vec3d{-0.1, 0, 0},
                               {51.3, 0, 0},
                               {1, -25.7, 0},
                               {1, 25.7, 0},
                               {1, 0, -2.1},
                               {1, 0, 4.5},
                               {NAN, 0, 0},
                               {1, INFINITY, 0}}) {
    EXPECT_EQ(grid.at(outside), std::nullopt) << outside.x;
  }
}

TEST(VoxelGrid, WhatLiesBetweenTwoVoxelsIsInTheUpperWhateverTheRounding) {
  const VoxelGrid grid;
  for (int i = 0; i < 32; ++i) {
    for (const double error : {-1e-5, -1e-9, 0.0, 1e-9, 1e-5}) {
      EXPECT_EQ(grid.at({1.1, 0.1, -2 + 0.2 * i + error}), grid.index(5, 128, static_cast<std::uint32_t>(i)));
    }
  }
}

}  // namespace
}  // namespace scanmill
