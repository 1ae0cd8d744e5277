#include "evaluate/cloud_errors.h"

#include <limits>

#include "tests/support/directions.h"

namespace scanmill {
namespace {

constexpr int kSide = 40;

// Points 1 m apart, moved by `shift`.
std::vector<Vec3f> gridAt(const Vec3f& shift) {
  std::vector<Vec3f> points;
  for (int x = 0; x < kSide; ++x) {
    for (int y = 0; y < kSide; ++y) points.push_back(shift + Vec3f{static_cast<float>(x), static_cast<float>(y), 0});
  }
  return points;
}

std::vector<Vec3f> scattered(std::size_t count, std::uint32_t stream, double radius) {
  std::vector<Vec3f> points;
  for (const Vec3d& d : randomDirections(count, stream)) points.push_back(Vec3f(d * radius));
  return points;
}

CloudErrors cloudErrors(std::span<const Vec3f> truth, std::span<const Vec3f> tested) {
  CloudErrorSum sum;
  sum.add(cloudDistances(truth, tested));
  return sum.finish();
}

TEST(CloudErrors, OfParallelGridsAreTheirDistance) {
  const CloudErrors e = cloudErrors(gridAt({}), gridAt({0, 0, 0.25f}));
  for (const Spread& s : {e.to, e.from}) {
    EXPECT_EQ(s.count, 1600u);
    EXPECT_EQ(s.mean, 0.25);
    EXPECT_EQ(s.median, 0.25);
  }
  EXPECT_EQ(e.hausdorff, 0.25);
  EXPECT_EQ(e.unmatched, 0u);
}

// Moved by three quarters of a step within its plane, every point finds a neighbour a quarter away, but for one row.
TEST(CloudErrors, OfAShiftedGridAreInClosedForm) {
  const CloudErrors e = cloudErrors(gridAt({}), gridAt({0.75f, 0, 0}));
  for (const Spread& s : {e.to, e.from}) {
    EXPECT_EQ(s.median, 0.25);
    EXPECT_DOUBLE_EQ(s.mean, 0.25 + 0.5 / kSide);
    EXPECT_EQ(s.max, 0.75);
  }
  EXPECT_EQ(e.hausdorff, 0.75);
}

TEST(CloudErrors, AreThoseOfBruteForce) {
  const std::vector<Vec3f> a = scattered(300, 1, 10);
  const std::vector<Vec3f> b = scattered(200, 2, 10.5);
  const auto nearest = [](const Vec3f& p, const std::vector<Vec3f>& cloud) {
    double least = INFINITY;
    for (const Vec3f& q : cloud) least = std::min(least, length(Vec3d(p) - Vec3d(q)));
    return least;
  };
  double to = 0, from = 0, farthest = 0;
  for (const Vec3f& p : a) {
    to += nearest(p, b) / 300;
    farthest = std::max(farthest, nearest(p, b));
  }
  for (const Vec3f& p : b) {
    from += nearest(p, a) / 200;
    farthest = std::max(farthest, nearest(p, a));
  }
  const CloudErrors e = cloudErrors(a, b);
  EXPECT_NEAR(e.to.mean, to, 1e-5);
  EXPECT_NEAR(e.from.mean, from, 1e-5);
  EXPECT_NEAR(e.hausdorff, farthest, 1e-5);
}

TEST(CloudErrors, AreDefinedForFewPointsAndNone) {
  const CloudErrors nothing = cloudErrors({}, {});
  EXPECT_EQ(nothing.to.count, 0u);
  EXPECT_EQ(nothing.from.count, 0u);
  EXPECT_EQ(nothing.hausdorff, 0);
  EXPECT_EQ(nothing.unmatched, 0u);
  const std::vector<Vec3f> one{{1, 2, 3}};
  const CloudErrors same = cloudErrors(one, one);
  EXPECT_EQ(same.to.count, 1u);
  EXPECT_EQ(same.hausdorff, 0);
  for (const CloudErrors& e : {cloudErrors(one, {}), cloudErrors({}, one)}) {
    EXPECT_EQ(e.to.count, 0u);
    EXPECT_EQ(e.from.count, 0u);
    EXPECT_EQ(e.unmatched, 1u);
    EXPECT_EQ(e.hausdorff, 0);
  }
}

TEST(CloudErrors, PointsThatAreNotFiniteDoNotCount) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Vec3f> nowhere{{kNaN, kNaN, kNaN}, {INFINITY, 0, 0}};
  std::vector<Vec3f> grid = gridAt({});
  EXPECT_EQ(cloudErrors(nowhere, grid).unmatched, 1600u);
  EXPECT_EQ(cloudErrors(nowhere, nowhere).unmatched, 0u);
  grid.insert(grid.end(), nowhere.begin(), nowhere.end());
  const CloudErrors e = cloudErrors(grid, gridAt({}));
  EXPECT_EQ(e.to.count, 1600u);
  EXPECT_EQ(e.hausdorff, 0);
}

TEST(CloudDistances, AreOfEachPointInItsPlace) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Vec3f> truth{{0, 0, 0}, {kNaN, 0, 0}, {4, 0, 0}};
  const std::vector<Vec3f> tested{{INFINITY, 0, 0}, {1, 0, 0}};
  const CloudDistances d = cloudDistances(truth, tested);
  ASSERT_EQ(d.to.size(), 3u);
  EXPECT_EQ(d.to[0], 1);
  EXPECT_TRUE(std::isnan(d.to[1]));
  EXPECT_EQ(d.to[2], 3);
  ASSERT_EQ(d.from.size(), 2u);
  EXPECT_TRUE(std::isnan(d.from[0]));
  EXPECT_EQ(d.from[1], 1);
  EXPECT_EQ(d.unmatched, 0u);
  const CloudDistances alone = cloudDistances(truth, {});
  ASSERT_EQ(alone.to.size(), 3u);
  for (const float distance : alone.to) EXPECT_TRUE(std::isnan(distance));
  EXPECT_TRUE(alone.from.empty());
  EXPECT_EQ(alone.unmatched, 2u);
}

// Shots see each their own surroundings: points of one are no neighbours to those of another.
TEST(CloudErrors, PoolPairByPair) {
  CloudErrorSum sum;
  sum.add(cloudDistances(gridAt({}), gridAt({0, 0, 0.25f})));
  sum.add(cloudDistances(gridAt({0, 0, 0.25f}), gridAt({0, 0, 1.25f})));
  sum.add(cloudDistances({}, std::vector<Vec3f>{{0, 0, 0}}));
  const CloudErrors e = sum.finish();
  EXPECT_EQ(e.to.count, 3200u);
  EXPECT_EQ(e.to.mean, 0.625);
  EXPECT_EQ(e.from.mean, 0.625);
  EXPECT_EQ(e.hausdorff, 1);
  EXPECT_EQ(e.unmatched, 1u);
}

}  // namespace
}  // namespace scanmill
