#include "tests/core/sense/several_returns.h"

namespace scanmill {
namespace {

double reportedElevation(const Vec3d& p) {
  return std::atan2(p.z, std::hypot(p.x, p.y));
}

Vec3d reportedPoint(const World& world, const Returns& returns, std::size_t row) {
  const Vec3d along = world.shot.beams->direction[returns.beam(row)] * double{returns.range[row]};
  return returns.displacement.empty() ? along : along + Vec3d(returns.displacement[row]);
}

TEST(RingBias, ListsAreTakenRingByRing) {
  const World world = makeWorld(3, 50);
  const Returns returns =
      run(world,
          {"ring_bias: {range_m: [0.5, 0, -0.25], elevation_deg: [1, -0.5, 0], gain: [0.5, 1, 2]}", "intensity: {}"});
  const double offset[] = {0.5, 0, -0.25};
  const double tilt[] = {1, -0.5, 0};
  const float gain[] = {0.5f, 1, 2};
  for (std::size_t row = 0; row < returns.size(); ++row) {
    const std::size_t ring = row / 50;
    EXPECT_FLOAT_EQ(returns.range[row], static_cast<float>(10 + offset[ring]));
    EXPECT_EQ(returns.power[row], gain[ring]);
    // The hit is where it is; the report says another elevation for it, and then another range along the beam.
    const Vec3d turned = world.shot.beams->direction[row] * 10.0 + Vec3d(returns.displacement[row]);
    EXPECT_NEAR(length(turned), 10, 1e-5);
    const double before = reportedElevation(world.shot.beams->direction[row]);
    EXPECT_NEAR(degrees(reportedElevation(turned) - before), tilt[ring], 1e-4);
    const double azimuth = std::atan2(world.shot.beams->direction[row].y, world.shot.beams->direction[row].x);
    EXPECT_NEAR(std::remainder(std::atan2(turned.y, turned.x) - azimuth, 2 * kPi), 0, 1e-6);
  }
}

TEST(RingBias, SpreadsAreGaussianOverTheRings) {
  const World world = makeWorld(4096, 1);
  const Returns returns =
      run(world, {"ring_bias: {range_sigma_m: 0.03, elevation_sigma_deg: 0.1, gain_sigma: 0.2}", "intensity: {}"});
  std::vector<double> offset;
  std::vector<double> tilt;
  std::vector<double> logGain;
  for (std::size_t row = 0; row < returns.size(); ++row) {
    offset.push_back(returns.range[row] - 10.0);
    const Vec3d turned = world.shot.beams->direction[row] * 10.0 + Vec3d(returns.displacement[row]);
    tilt.push_back(degrees(reportedElevation(turned) - reportedElevation(world.shot.beams->direction[row])));
    logGain.push_back(std::log(returns.gain[row]));
  }
  const double sigmas[] = {0.03, 0.1, 0.2};
  const std::vector<double>* const all[] = {&offset, &tilt, &logGain};
  for (int k = 0; k < 3; ++k) {
    const Moments m = momentsOf(*all[k]);
    EXPECT_NEAR(m.mean / sigmas[k], 0, 5 / 64.0) << k;
    EXPECT_NEAR(std::sqrt(m.variance) / sigmas[k], 1, 5 / std::sqrt(2 * 4096.0)) << k;
    EXPECT_NEAR(m.kurtosis, 3, 5 * std::sqrt(24 / 4096.0)) << k;
    EXPECT_NEAR(correlation(*all[k], *all[(k + 1) % 3]), 0, 5 / 64.0) << k;
  }
}

TEST(RingBias, BelongsToTheSensorNotToTheFrame) {
  World world = makeWorld(16, 20);
  const std::vector<std::string> yaml{"ring_bias: {range_sigma_m: 0.03, gain_sigma: 0.2}", "intensity: {}"};
  const Returns first = run(world, yaml);
  for (std::size_t row = 0; row < first.size(); ++row) {
    EXPECT_EQ(first.range[row], first.range[row / 20 * 20]) << "all beams of a ring share it";
  }
  world.shot.frame = 7;
  world.shot.scene = 3;
  EXPECT_EQ(run(world, yaml).range, first.range);
  EXPECT_EQ(run(world, yaml).power, first.power);
  world.shot.sensor = 1;
  EXPECT_NE(run(world, yaml).range, first.range);
  world.shot.sensor = 0;
  world.shot.seed += 1;
  EXPECT_NE(run(world, yaml).range, first.range);
}

TEST(RingBias, MissesStayMissesAndNoPointPassesTheSensor) {
  World world = makeRaggedWorld(2, 200);
  world.hits.range[3] = 0.2f;
  const Returns returns = run(world, {"ring_bias: {range_m: [-0.5, 3]}"});
  for (std::size_t row = 0; row < returns.size(); ++row) {
    EXPECT_EQ(returns.returned(row), world.hits.hit(row));
    EXPECT_GE(returns.range[row], 0.001f);
  }
  EXPECT_EQ(returns.range[3], 0.001f);
  EXPECT_TRUE(returns.gain.empty()) << "nothing was asked of the gain";
  EXPECT_TRUE(returns.displacement.empty());
}

TEST(RingBias, AllReturnsOfABeamHaveTheErrorsOfItsRing) {
  const World world = makeSeveralReturns(3, 60);
  const Returns returns = run(world, {"ring_bias: {range_m: [0.5, 0, -0.25], elevation_deg: [1, 1, 1]}"});
  const double offset[] = {0.5, 0, -0.25};
  for (std::size_t row = 0; row < returns.size(); ++row) {
    const std::uint32_t beam = returns.beam(row);
    const float exact = world.hits.range[returns.hit(row)];
    EXPECT_FLOAT_EQ(returns.range[row], static_cast<float>(exact + offset[beam / 60]));
    EXPECT_NEAR(degrees(reportedElevation(reportedPoint(world, returns, row)) -
                        reportedElevation(world.shot.beams->direction[beam])),
                1, 0.1);
  }
}

TEST(RingBias, RefusesBadOptions) {
  const auto effect = makeEffect("ring_bias: {range_m: [0.1, 0.2]}");
  BeamTable beams;
  beams.rings = 2;
  effect->check(beams);
  beams.rings = 3;
  expectInputError([&] { effect->check(beams); }, {"test.yaml:1", "number of values is 2", "number of rings is 3"});
}

}  // namespace
}  // namespace scanmill
