#include "evaluate/registration.h"

#include <random>

#include "base/parallel.h"

namespace scanmill {
namespace {

// The fitness of two clouds where they are.
std::optional<double> fitness(std::span<const Vec3f> source, std::span<const Vec3f> target) {
  return registerClouds(source, target).unmoved;
}

using Points = std::vector<Vec3f>;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// What the fitness is said to be, by all distances.
double meanOfSquares(const Points& source, const Points& target) {
  double sum = 0;
  for (const Vec3f& s : source) {
    double nearest = INFINITY;
    for (const Vec3f& t : target) {
      const Vec3d d = static_cast<Vec3d>(s) - static_cast<Vec3d>(t);
      if (dot(d, d) < nearest) nearest = dot(d, d);
    }
    sum += nearest;
  }
  return sum / static_cast<double>(source.size());
}

Points randomCloud(std::size_t count, unsigned seed, float offset = 0) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> side(-1, 1);
  Points points(count);
  for (Vec3f& p : points) p = {offset + side(random), side(random), side(random)};
  return points;
}

// Three faces of a box of 1.2 x 0.8 x 0.5 m that meet in a corner: what a sensor sees of it from above.
Points boxCloud() {
  Points points;
  for (int i = 0; i <= 24; ++i) {
    for (int j = 0; j <= 24; ++j) {
      const float a = static_cast<float>(i) / 24;
      const float b = static_cast<float>(j) / 24;
      points.push_back({1.2f * a, 0.8f * b, 0.5f});
      points.push_back({1.2f * a, 0, 0.5f * b});
      points.push_back({0, 0.8f * a, 0.5f * b});
    }
  }
  return points;
}

Points moved(const Points& points, const Affine& motion) {
  Points result;
  for (const Vec3f& p : points) result.push_back(static_cast<Vec3f>(motion * static_cast<Vec3d>(p)));
  return result;
}

Affine motionOf(double yawDeg, double pitchDeg, const Vec3d& translation) {
  return {toMatrix(fromYawPitchRoll(radians(yawDeg), radians(pitchDeg), 0)), translation};
}

TEST(FitnessScore, IsTheMeanOfSquaredNearestDistances) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Points a = randomCloud(300, seed);
    const Points b = randomCloud(200, seed + 100, 0.3f);
    EXPECT_NEAR(*fitness(a, b), meanOfSquares(a, b), 1e-6 * meanOfSquares(a, b));
    EXPECT_NEAR(*fitness(b, a), meanOfSquares(b, a), 1e-6 * meanOfSquares(b, a));
    EXPECT_NE(*fitness(a, b), *fitness(b, a));
  }
}

TEST(FitnessScore, FewAndStrangePointsHaveDefinedResults) {
  const Points none;
  const Points one{{1, 2, 3}};
  const Points two{{1, 2, 3}, {1, 2, 4}};
  const Points nan{{kNaN, 0, 0}, {0, kNaN, 0}, {0, 0, INFINITY}};
  for (const Points& empty : {none, nan}) {
    EXPECT_EQ(fitness(empty, empty), std::nullopt);
    EXPECT_EQ(fitness(one, empty), std::nullopt);
    EXPECT_EQ(fitness(empty, one), std::nullopt);
    EXPECT_FALSE(registerClouds(empty, one).moved);
    EXPECT_FALSE(registerClouds(one, empty).moved);
    EXPECT_EQ(registerClouds(empty, empty).fitness, std::nullopt);
  }
  EXPECT_EQ(*fitness(one, one), 0);
  EXPECT_NEAR(*fitness(two, one), 0.5, 1e-7);
  for (const Points& few : {one, two}) {
    const Registered result = registerClouds(few, boxCloud());
    EXPECT_FALSE(result.moved);
    EXPECT_EQ(result.fitness, fitness(few, boxCloud()));
    EXPECT_FALSE(registerClouds(boxCloud(), few).moved);
  }
  Points torn = boxCloud();
  torn.insert(torn.begin() + 7, nan.begin(), nan.end());
  EXPECT_EQ(fitness(torn, one), fitness(boxCloud(), one));
  EXPECT_EQ(fitness(one, torn), fitness(one, boxCloud()));
  EXPECT_EQ(registerClouds(torn, torn).fitness, registerClouds(boxCloud(), boxCloud()).fitness);
}

// All on one point or one line: no rotation is better than another.
TEST(Icp, DegenerateCloudsStayFinite) {
  const Points heap(10, Vec3f{1, 1, 1});
  Points line;
  for (int i = 0; i < 10; ++i) line.push_back({static_cast<float>(i), 0, 0});
  for (const Points& source : {heap, line}) {
    for (const Points& target : {heap, line}) {
      const Registered result = registerClouds(source, target);
      ASSERT_TRUE(result.fitness);
      EXPECT_TRUE(std::isfinite(*result.fitness));
    }
  }
}

TEST(Icp, FindsASmallMotion) {
  const Points box = boxCloud();
  const Affine motion = motionOf(0.6, -0.4, {0.008, -0.005, 0.006});
  for (const Vec3d& far : {Vec3d{}, Vec3d{300, -200, 50}}) {
    const Affine there{Mat3{}, far};
    const Points target = moved(box, there * motion);
    const Registered result = registerClouds(moved(box, there), target, 200);
    ASSERT_TRUE(result.moved);
    EXPECT_GT(*result.unmoved, 1e-5);
    EXPECT_LT(*result.fitness, 1e-8);
  }
}

TEST(Icp, MoreStepsNeverFitMuchWorse) {
  const Points box = boxCloud();
  const Points target = moved(box, motionOf(4, 0, {0.1, 0.05, 0}));
  double last = *fitness(box, target);
  for (const int iterations : {1, 2, 5, 10, 50}) {
    const double now = *registerClouds(box, target, iterations).fitness;
    EXPECT_LE(now, last * (1 + 1e-6)) << iterations;
    last = now;
  }
}

TEST(FitnessSpread, IsThatOfTheSample) {
  const std::vector<std::optional<double>> values{2, std::nullopt, 4, 9, std::nullopt};
  const FitnessSpread spread = fitnessSpread(values);
  EXPECT_EQ(spread.count, 3u);
  EXPECT_DOUBLE_EQ(spread.mean, 5);
  EXPECT_DOUBLE_EQ(spread.deviation, std::sqrt((9.0 + 1 + 16) / 2));
  EXPECT_EQ(spread.low, 2);
  EXPECT_EQ(spread.high, 9);
  const std::vector<std::optional<double>> one{3};
  EXPECT_EQ(fitnessSpread(one).deviation, 0);
  EXPECT_EQ(fitnessSpread({}).count, 0u);
}

}  // namespace
}  // namespace scanmill
