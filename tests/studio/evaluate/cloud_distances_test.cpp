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
  const auto expectNearest = [](const std::vector<float>& found, const auto& from, const auto& cloud) {
    ASSERT_EQ(found.size(), from.size());
    for (std::size_t i = 0; i < from.size(); ++i) {
      double least = INFINITY;
      for (const Vec3f& q : cloud) least = std::min(least, length(Vec3d(from[i]) - Vec3d(q)));
      EXPECT_NEAR(found[i], least, 1e-5);
    }
  };
  const CloudDistances d = cloudDistances(a, b);
  expectNearest(d.to, a, b);
  expectNearest(d.from, b, a);
}

TEST(CloudDistances, AreUnknownForPointsThatAreNotFiniteAndForEmptyClouds) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Vec3f> truth{{0, 0, 0}, {kNaN, 0, 0}, {4, 0, 0}};
  const std::vector<Vec3f> tested{{INFINITY, 0, 0}, {1, 0, 0}};
  const CloudDistances d = cloudDistances(truth, tested);
  EXPECT_THAT(d.to, testing::ElementsAre(1, testing::IsNan(), 3));
  EXPECT_THAT(d.from, testing::ElementsAre(testing::IsNan(), 1));
  for (const std::vector<Vec3f>& empty : {std::vector<Vec3f>{}, {{kNaN, 0, 0}}}) {
    EXPECT_THAT(cloudDistances(truth, empty).to, testing::Each(testing::IsNan()));
    EXPECT_THAT(cloudDistances(empty, truth).from, testing::Each(testing::IsNan()));
  }
}

}  // namespace
}  // namespace scanmill
