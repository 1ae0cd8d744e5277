#include "tests/core/sense/world.h"

namespace scanmill {
namespace {

std::size_t lost(const Returns& returns) {
  return static_cast<std::size_t>(std::count(returns.range.begin(), returns.range.end(), kMiss));
}

TEST(DropOut, RandomLossesAreBinomial) {
  const World world = makeWorld(256, 1024);
  const double n = static_cast<double>(world.hits.size());
  for (double p : {0.001, 0.05, 0.5, 0.95}) {
    const Returns returns = run(world, {"dropout: {probability: " + std::to_string(p) + "}"});
    EXPECT_NEAR(static_cast<double>(lost(returns)), n * p, 5 * std::sqrt(n * p * (1 - p))) << p;
  }
}

// A share of the rings, to the nearest number; the same in all frames, others of another sensor or seed; more of them
// are those and others.
TEST(DropOut, RingsAreLostAsAWhole) {
  const auto rings = [](World world, double share) {
    const Returns returns = run(world, {"dropout: {rings: " + std::to_string(share) + "}"});
    std::vector<std::uint32_t> silent;
    for (std::uint32_t ring = 0; ring < 64; ++ring) {
      const auto first = returns.range.begin() + ring * 16;
      const auto gone = std::count(first, first + 16, kMiss);
      EXPECT_TRUE(gone == 0 || gone == 16) << ring;
      if (gone == 16) silent.push_back(ring);
    }
    return silent;
  };
  World world = makeWorld(64, 16);
  const auto quarter = rings(world, 0.25);
  const auto half = rings(world, 0.5);
  EXPECT_EQ(quarter.size(), 16U);
  EXPECT_EQ(half.size(), 32U);
  EXPECT_TRUE(std::includes(half.begin(), half.end(), quarter.begin(), quarter.end()));
  EXPECT_EQ(rings(world, 0.007).size(), 0U);
  EXPECT_EQ(rings(world, 1).size(), 64U);
  world.shot.frame += 5;
  EXPECT_EQ(rings(world, 0.25), quarter);
  world.shot.sensor += 1;
  EXPECT_NE(rings(world, 0.25), quarter);
}

TEST(DropOut, OnlyThingsAreLostWhereItSaysSo) {
  World world = makeWorld(64, 64);
  world.hits.instance.assign(world.hits.size(), 0);
  for (std::size_t b = 0; b < world.hits.size(); b += 2) world.hits.instance[b] = 7;
  const Returns some = run(world, {"dropout: {probability: 0.75, things: true}"});
  const Returns all = run(world, {"dropout: {probability: 0.75}"});
  for (std::size_t b = 0; b < world.hits.size(); ++b) {
    EXPECT_EQ(some.range[b], b % 2 == 0 ? all.range[b] : world.hits.range[b]);
  }
}

TEST(DropOut, LossesGrowWithTheProbabilityBeamByBeam) {
  const World world = makeRaggedWorld(16, 100);
  const Returns few = run(world, {"dropout: {probability: 0.2}"});
  const Returns many = run(world, {"dropout: {probability: 0.6}"});
  for (std::size_t b = 0; b < few.range.size(); ++b) {
    if (few.range[b] == kMiss) {
      EXPECT_EQ(many.range[b], kMiss);
    }
    if (many.range[b] != kMiss) {
      EXPECT_EQ(many.range[b], world.hits.range[b]);
    }
  }
}

TEST(DropOut, FaintEchoesAreLostAtTheirClosedFormRange) {
  // White: 100 / r^2 reaches 0.04 at 50 m; the response must not matter.
  World world = makeWorld(1, 1000);
  for (int i = 0; i < 1000; ++i) world.hits.range[i] = 0.1f * static_cast<float>(i + 1);
  const Returns returns = run(world, {"intensity: {gain: 1000, output: u8}", "dropout: {threshold: 0.04}"});
  for (std::size_t i = 0; i < 1000; ++i) {
    if (std::abs(world.hits.range[i] - 50) < 0.01) continue;
    const bool kept = world.hits.range[i] < 50;
    EXPECT_EQ(returns.range[i], kept ? world.hits.range[i] : kMiss);
    EXPECT_EQ(returns.intensity[i] > 0, kept);
  }
}

TEST(DropOut, ThresholdNeedsTheIntensity) {
  EXPECT_TRUE(makeEffect("dropout: {threshold: 0.1}")->needsIntensity());
  EXPECT_FALSE(makeEffect("dropout: {threshold: 0}")->needsIntensity());
  EXPECT_FALSE(makeEffect("dropout: {probability: 0.1}")->needsIntensity());
  const World world = makeWorld(2, 2);
  EXPECT_THROW(run(world, {"dropout: {threshold: 0.1}"}), InputError);
}

}  // namespace
}  // namespace scanmill
