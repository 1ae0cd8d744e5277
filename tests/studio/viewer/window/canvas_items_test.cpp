#include "viewer/window/canvas_items.h"

#include <limits>
#include <random>

namespace scanmill {
namespace {

TEST(Guides, AxesAreThePosesOwn) {
  const Affine pose = toAffine(Pose{fromYawPitchRoll(0.4, -0.2, 0.1), {1, 2, 3}});
  LineSet lines;
  addAxes(lines, pose, 2);
  ASSERT_EQ(lines.colors.size(), 3u);
  const Vec3d axes[] = {pose.linear.x, pose.linear.y, pose.linear.z};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(length(Vec3d(lines.ends[2 * i]) - pose.translation), 0, 1e-6);
    EXPECT_NEAR(length(Vec3d(lines.ends[2 * i + 1]) - pose.translation - axes[i] * 2.0), 0, 1e-6);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_LE(lines.colors[i][c], lines.colors[i][i]);
  }
}

TEST(Guides, RangeRingsAreClosedAndAsFarAsTheySay) {
  LineSet lines;
  const Vec3d center{5, -3, -1.8};
  addRangeRings(lines, center, {1, 2, 3});
  const std::size_t each = lines.colors.size() / kRingRadii.size();
  ASSERT_EQ(each * kRingRadii.size() * 2, lines.ends.size());
  for (std::size_t i = 0; i < lines.ends.size(); ++i) {
    const Vec3d p = Vec3d(lines.ends[i]) - center;
    EXPECT_NEAR(p.z, 0, 1e-5);
    EXPECT_NEAR(length(p), kRingRadii[i / 2 / each], 1e-4);
  }
  for (std::size_t r = 0; r < kRingRadii.size(); ++r) {
    EXPECT_NEAR(length(lines.ends[2 * r * each] - lines.ends[2 * (r + 1) * each - 1]), 0, 1e-4);
  }
}

TEST(Guides, ATrackGoesThroughAllPlaces) {
  const std::vector<Vec3d> places{{0, 0, 0}, {1, 0, 0}, {2, 1, 0}, {3, 3, 0}};
  LineSet lines;
  addTrack(lines, places, 2, {200, 100, 50});
  ASSERT_GT(lines.colors.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(Vec3d(lines.ends[2 * i]), places[i]);
    EXPECT_EQ(Vec3d(lines.ends[2 * i + 1]), places[i + 1]);
  }
  EXPECT_NE(lines.colors[0], lines.colors[2]);
  EXPECT_EQ(lines.colors[0], lines.colors[1]);  // both lie behind
  for (std::size_t i = 6; i < lines.ends.size(); ++i) {
    EXPECT_NEAR(length(Vec3d(lines.ends[i]) - places[2]), 0.5, 1e-6);  // the mark
  }
}

// A twentieth of the points lies below, in whatever order, and those without a place do not count.
TEST(Guides, TheGroundIsTheFifthPercentile) {
  std::vector<Vec3f> points;
  for (int i = 0; i <= 1000; ++i) points.push_back({1, 2, static_cast<float>(i) * 0.01F});
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  points.insert(points.end(), 500, {kNan, kNan, kNan});
  std::shuffle(points.begin(), points.end(), std::mt19937(1));
  EXPECT_NEAR(groundHeight(points, {}), 0.5, 1e-6);
  EXPECT_NEAR(groundHeight(points, {{}, {0, 0, 7}}), 7.5, 1e-6);
  EXPECT_EQ(groundHeight({}, {}), 0);
}

}  // namespace
}  // namespace scanmill
