#include "base/path.h"
#include "sensors/trajectory.h"

namespace scanmill {
namespace {

Path straight(double length) {
  return Path({{0, 0, 0}, {length / 2, 0, 0}, {length, 0, 0}});
}

TEST(SpeedProfile, OfOneSpeed) {
  const SpeedProfile p(100, 8);
  EXPECT_DOUBLE_EQ(p.duration(), 12.5);
  EXPECT_DOUBLE_EQ(p.distance(3), 24);
  EXPECT_DOUBLE_EQ(p.timeAt(24), 3);
  EXPECT_EQ(p.distance(-1), 0);
  EXPECT_EQ(p.distance(99), 100);
  EXPECT_EQ(p.speed(5), 8);
}

// From rest to rest over a length s at an acceleration a, with a top speed v: s / v + v / a where the top is reached,
// 2 sqrt(s / a) where it is not.
TEST(SpeedProfile, FromRestToRest) {
  const SpeedProfile far(straight(200), 10, 2, {});
  EXPECT_NEAR(far.duration(), 200.0 / 10 + 10.0 / 2, 1e-6);
  EXPECT_NEAR(far.distance(2), 2 * 2 * 2 / 2.0, 1e-6);
  EXPECT_NEAR(far.speed(2), 4, 1e-6);
  EXPECT_NEAR(far.speed(12), 10, 1e-9);
  EXPECT_NEAR(200 - far.distance(far.duration() - 3), 2 * 3 * 3 / 2.0, 1e-6);
  EXPECT_EQ(far.speed(0), 0);
  EXPECT_NEAR(far.speed(far.duration()), 0, 1e-9);
  const SpeedProfile near(straight(20), 50, 2, {});
  EXPECT_NEAR(near.duration(), 2 * std::sqrt(20 / 2.0), 1e-3);
}

TEST(SpeedProfile, StopsWait) {
  const SpeedProfile p(straight(200), 10, 2, {{60, 4}, {120.1, 2}});
  const double arrived = p.timeAt(60);
  EXPECT_NEAR(arrived, 60.0 / 10 + 10.0 / 2, 1e-6);
  for (const double t : {0.0, 2.0, 3.99}) {
    EXPECT_NEAR(p.distance(arrived + t), 60, 1e-9);
    EXPECT_NEAR(p.speed(arrived + t), 0, 1e-9);
  }
  EXPECT_GT(p.distance(arrived + 4.5), 60.1);
  EXPECT_NEAR(p.duration(), 200.0 / 10 + 3 * 10.0 / 2 + 6, 1e-4);
}

// The derivative of the distance is the speed, neither jumps, and no acceleration is above the given one; in the bend
// v^2 / r is at most 2 m/s^2.
TEST(SpeedProfile, IsSmoothAndSlowInBends) {
  constexpr double kRadius = 12;
  std::vector<Vec3d> points{{-60, -kRadius, 0}, {-40, -kRadius, 0}, {-20, -kRadius, 0}};
  for (int k = 0; k <= 18; ++k) {
    const double a = radians(-90 + 10.0 * k / 2);
    points.push_back({kRadius * std::cos(a), kRadius * std::sin(a), 0});
  }
  for (const double y : {20.0, 40.0, 60.0}) points.push_back({kRadius, y, 0});
  const Path path(points);
  const SpeedProfile p(path, 14, 1.5, {{20, 1}});
  constexpr double kStep = 0.01;
  double slowest = 99;
  for (double t = 0; t + kStep < p.duration(); t += kStep) {
    const double v = (p.distance(t + kStep) - p.distance(t)) / kStep;
    ASSERT_NEAR(v, (p.speed(t) + p.speed(t + kStep)) / 2, 0.02) << t;
    ASSERT_LE(std::abs(p.speed(t + kStep) - p.speed(t)) / kStep, 1.5 * 1.01 + 1e-6) << t;
    const double at = p.distance(t);
    if (at > 65 && at < 72) slowest = std::min(slowest, p.speed(t));
  }
  EXPECT_NEAR(slowest, std::sqrt(SpeedProfile::kSideways * kRadius), 0.4);
}

TEST(SpeedProfile, TimesAndDistancesAreInverse) {
  const SpeedProfile p(straight(150), 12, 1.1, {{40, 3}});
  for (double s = 0; s <= 150; s += 0.37) EXPECT_NEAR(p.distance(p.timeAt(s)), s, 1e-6) << s;
}

}  // namespace
}  // namespace scanmill
