#include "evaluate/cloud_distance.h"

#include <gtest/gtest.h>

#include <limits>

#include "base/error.h"

namespace scanmill {
namespace {

std::vector<Vec3f> grid(float z) {
  std::vector<Vec3f> points;
  for (int x = 0; x < 40; ++x) {
    for (int y = 0; y < 40; ++y) points.push_back({static_cast<float>(x), static_cast<float>(y), z});
  }
  return points;
}

TEST(CloudDistance, ParallelGridsAreTheirDistanceApart) {
  const Spread s = nearestDistances(grid(0), grid(0.25f));
  EXPECT_EQ(s.count, 1600u);
  EXPECT_EQ(s.mean, 0.25);
  EXPECT_EQ(s.max, 0.25);
  EXPECT_EQ(nearestDistances(grid(1), grid(1)).max, 0);
}

// The published figure looks one way only and cannot see points that do not exist.
TEST(CloudDistance, IsBlindToSpuriousPointsOneWay) {
  std::vector<Vec3f> further = grid(0);
  further.push_back({0, 0, 100});
  EXPECT_EQ(nearestDistances(grid(0), further).max, 0);
  EXPECT_EQ(nearestDistances(further, grid(0)).max, 100);
}

TEST(CloudDistance, MissesAreLeftOut) {
  std::vector<Vec3f> points = grid(0);
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  points.push_back({kNaN, kNaN, kNaN});
  EXPECT_EQ(nearestDistances(points, grid(0)).count, 1600u);
  EXPECT_EQ(nearestDistances(grid(0), points).max, 0);
  EXPECT_EQ(nearestDistances({}, grid(0)).count, 0u);
  EXPECT_THROW(nearestDistances(grid(0), {}), Error);
}

}  // namespace
}  // namespace scanmill
