#include "tests/core/sense/world.h"

namespace scanmill {
namespace {

// Direction of the reported point, seen from the beam's origin.
Vec3d reported(const World& world, const Returns& returns, std::size_t beam) {
  return world.shot.beams->direction[beam] * static_cast<double>(returns.range[beam]) +
         static_cast<Vec3d>(returns.displacement[beam]);
}

double elevationOf(const Vec3d& p) {
  return std::atan2(p.z, std::hypot(p.x, p.y));
}

double azimuthBetween(const Vec3d& a, const Vec3d& b) {
  return std::atan2(a.x * b.y - a.y * b.x, a.x * b.x + a.y * b.y);
}

TEST(AngularJitter, AnglesHaveTheirSigmas) {
  const World world = makeWorld(64, 2048, 40);
  const Returns returns = run(world, {"angular_jitter: {azimuth_sigma_deg: 0.2, elevation_sigma_deg: 0.05}"});
  std::vector<double> azimuth;
  std::vector<double> elevation;
  for (std::size_t b = 0; b < world.hits.size(); ++b) {
    const Vec3d p = reported(world, returns, b);
    azimuth.push_back(degrees(azimuthBetween(world.shot.beams->direction[b], p)));
    elevation.push_back(degrees(elevationOf(p) - elevationOf(world.shot.beams->direction[b])));
  }
  const double n = std::sqrt(static_cast<double>(world.hits.size()));
  const Moments a = momentsOf(azimuth);
  const Moments e = momentsOf(elevation);
  EXPECT_NEAR(a.mean, 0, 5 * 0.2 / n);
  EXPECT_NEAR(e.mean, 0, 5 * 0.05 / n);
  EXPECT_NEAR(std::sqrt(a.variance) / 0.2, 1, 5 / n);
  EXPECT_NEAR(std::sqrt(e.variance) / 0.05, 1, 5 / n);
  EXPECT_NEAR(a.kurtosis, 3, 5 * std::sqrt(24.0) / n);
  EXPECT_NEAR(correlation(azimuth, elevation), 0, 5 / n);
}

TEST(AngularJitter, KeepsTheRange) {
  const World world = makeRaggedWorld(32, 500);
  const Returns returns = run(world, {"angular_jitter: {sigma_deg: 5}"});
  EXPECT_EQ(returns.range, world.hits.range);
  for (std::size_t b = 0; b < world.hits.size(); ++b) {
    if (!world.hits.hit(b)) {
      EXPECT_EQ(returns.displacement[b], Vec3f{});
      continue;
    }
    EXPECT_NEAR(length(reported(world, returns, b)) / world.hits.range[b], 1, 2e-7);
  }
}

TEST(AngularJitter, OneAxisLeavesTheOther) {
  const World world = makeWorld(16, 256, 40);
  const Returns turned = run(world, {"angular_jitter: {azimuth_sigma_deg: 1}"});
  const Returns tilted = run(world, {"angular_jitter: {elevation_sigma_deg: 1}"});
  for (std::size_t b = 0; b < world.hits.size(); ++b) {
    EXPECT_NEAR(turned.displacement[b].z, 0, 1e-6);
    EXPECT_NEAR(azimuthBetween(world.shot.beams->direction[b], reported(world, tilted, b)), 0, 1e-7);
  }
}

TEST(AngularJitter, VerticalBeamsTiltWithoutNaN) {
  World world = makeWorld(1, 2000, 10);
  for (Vec3d& d : world.beams().direction) d = {0, 0, 1};
  const Returns returns = run(world, {"angular_jitter: {sigma_deg: 1}"});
  double squares = 0;
  for (std::size_t b = 0; b < world.hits.size(); ++b) {
    const Vec3d p = reported(world, returns, b);
    ASSERT_TRUE(isFinite(p));
    squares += std::pow(std::atan2(std::hypot(p.x, p.y), p.z), 2);
  }
  EXPECT_NEAR(degrees(std::sqrt(squares / 2000)), 1, 5 / std::sqrt(2 * 2000.0));
}

}  // namespace
}  // namespace scanmill
