#include <cmath>
#include <limits>

#include "evaluate/measure.h"
#include "tests/support/directions.h"

namespace scanmill {
namespace {

std::vector<Vec3f> scattered(std::size_t count, std::uint32_t stream, double radius) {
  std::vector<Vec3f> points;
  for (const Vec3d& d : randomDirections(count, stream)) points.push_back(Vec3f(d * radius));
  return points;
}

TEST(CloudDistances, AreThoseOfBruteForce) {
  const std::vector<Vec3f> a = scattered(300, 1, 10);
  const std::vector<Vec3f> b = scattered(200, 2, 10.5);
  const std::vector<float> found = nearestDistances(a, b);
  ASSERT_EQ(found.size(), a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    double least = INFINITY;
    for (const Vec3f& q : b) least = std::min(least, length(Vec3d(a[i]) - Vec3d(q)));
    EXPECT_NEAR(found[i], least, 1e-5);
  }
}

TEST(CloudDistances, AreUnknownForPointsThatAreNotFiniteAndForEmptyClouds) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Vec3f> truth{{0, 0, 0}, {kNaN, 0, 0}, {4, 0, 0}};
  const std::vector<Vec3f> tested{{INFINITY, 0, 0}, {1, 0, 0}};
  EXPECT_THAT(nearestDistances(truth, tested), testing::ElementsAre(1, testing::IsNan(), 3));
  EXPECT_THAT(nearestDistances(tested, truth), testing::ElementsAre(testing::IsNan(), 1));
  for (const std::vector<Vec3f>& empty : {std::vector<Vec3f>{}, {{kNaN, 0, 0}}}) {
    EXPECT_THAT(nearestDistances(truth, empty), testing::Each(testing::IsNan()));
  }
}

}  // namespace
}  // namespace scanmill
