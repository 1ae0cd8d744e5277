#include <bit>

#include "sensors/footprint.h"
#include "tests/core/sense/world.h"

namespace scanmill {
namespace {

Moments errorsAt(float range, const std::string& options, std::uint32_t frame = 0) {
  World world = makeWorld(128, 1024, range);
  world.shot.frame = frame;
  const Returns returns = run(world, {"range_noise: " + options});
  std::vector<double> errors;
  for (float r : returns.range) errors.push_back(static_cast<double>(r) - range);
  return momentsOf(errors);
}

void expectSigma(const Moments& m, double sigma) {
  const double n = std::sqrt(128.0 * 1024.0);
  EXPECT_NEAR(m.mean, 0, 5 * sigma / n);
  EXPECT_NEAR(std::sqrt(m.variance) / sigma, 1, 5 / std::sqrt(2.0) / n + 1e-3);
}

TEST(RangeNoise, HasItsSigma) {
  expectSigma(errorsAt(20, "{sigma_m: 0.03}"), 0.03);
  expectSigma(errorsAt(20, "{sigma_per_m: 0.002}"), 0.04);
  expectSigma(errorsAt(20, "{sigma_m: 0.01, sigma_per_m: 0.002}"), 0.05);
}

TEST(RangeNoise, TableIsLinearBetweenItsRowsAndConstantBeyond) {
  const std::string table = "{table: [[5, 0.01], [15, 0.03], [25, 0.03], [45, 0.0]]}";
  expectSigma(errorsAt(2, table), 0.01);
  expectSigma(errorsAt(5, table), 0.01);
  expectSigma(errorsAt(10, table), 0.02);
  expectSigma(errorsAt(20, table), 0.03);
  expectSigma(errorsAt(35, table), 0.015);
  EXPECT_NEAR(errorsAt(45, table).variance, 0, 1e-12);
  EXPECT_NEAR(errorsAt(80, table).variance, 0, 1e-12);
  expectSigma(errorsAt(30, "{table: [[10, 0.02]]}"), 0.02);
}

TEST(RangeNoise, NeverFlipsARay) {
  for (float range : {1e-4f, 1e-3f, 0.01f, 1.0f, 1e4f}) {
    const World world = makeWorld(64, 256, range);
    for (const char* options : {"{sigma_m: 100}", "{sigma_per_m: 1}", "{table: [[0, 3], [2, 100]]}"}) {
      for (float r : run(world, {std::string("range_noise: ") + options}).range) {
        ASSERT_TRUE(std::isfinite(r));
        ASSERT_GE(r, std::min(range, 0.001f));
      }
    }
  }
}

TEST(RangeNoise, MissesStayMisses) {
  const World world = makeRaggedWorld(33, 77);
  for (const char* options : {"{sigma_m: 0.1, sigma_per_m: 0.1}", "{table: [[1, 0.3], [50, 0.1]]}"}) {
    const Returns returns = run(world, {std::string("range_noise: ") + options});
    for (std::size_t b = 0; b < world.hits.size(); ++b) EXPECT_EQ(returns.range[b] < kMiss, world.hits.hit(b));
  }
}

// Part of the data format: other machines, compilers and versions must give these very bits.
TEST(RangeNoise, GivesTheSameBitsOnEveryMachine) {
  const World world = makeWorld(1, 4, 30);
  const Returns returns = run(world, {"range_noise: {sigma_m: 0.05}"});
  std::vector<std::uint32_t> bits;
  for (float r : returns.range) bits.push_back(std::bit_cast<std::uint32_t>(r));
  EXPECT_EQ(bits, (std::vector<std::uint32_t>{1106312352, 1106217199, 1106232488, 1106209296}));
}

// sigma^2 = floor^2 + (over / snr)^2, for faint walls and for those that give all power.
TEST(RangeNoise, GrowsAsTheSignalFalls) {
  for (const double snr : {5.0, 20.0, 100.0}) {
    World world = makeWorld(64, 400, 30);
    world.beams().pulse = 5e-9;
    world.beams().maxRange = 100;
    const Returns returns =
        run(world, {"intensity: {falloff: none}", "detection: {threshold: 0.1, noise: " + std::to_string(1 / snr) + "}",
                    "range_noise: {sigma_m: 0.005, over_snr_m: 0.4}"});
    std::vector<double> errors;
    for (std::size_t beam = 0; beam < world.hits.size(); ++beam) {
      if (returns.cause(beam) == Reason::Surface && returns.returned(beam)) errors.push_back(returns.range[beam] - 30);
    }
    const double sigma = std::hypot(0.005, 0.4 / snr);
    EXPECT_NEAR(std::sqrt(momentsOf(errors).variance), sigma,
                4 * sigma / std::sqrt(2.0 * static_cast<double>(errors.size())))
        << snr;
  }
}

// A footprint's echo that is stretched over as many metres as the pulse is noisier by the root of 2.
TEST(RangeNoise, GrowsAsTheEchoIsStretched) {
  World world = makeWorld(1, 4000, 30);
  world.beams().pulse = 5e-9;
  world.beams().maxRange = 100;
  const double deviation = kLightSpeed * 5e-9 / 2 / 2.355;
  std::vector<Echo> echoes;
  for (std::uint32_t beam = 0; beam < 4000; ++beam) {
    echoes.push_back({beam, beam, 30, 1, beam % 2 == 0 ? 0 : static_cast<float>(deviation)});
  }
  Returns returns;
  returns.start(echoes, true);
  for (const auto& effect :
       makeEffects({"intensity: {falloff: none}", "detection: {noise: 0.1}", "range_noise: {over_snr_m: 0.4}"})) {
    effect->apply(world.hits, world.shot, world.materials, returns);
  }
  std::vector<double> errors[2];
  for (std::size_t row = 0; row < 4000; ++row) {
    if (returns.returned(row)) errors[row % 2].push_back(returns.range[row] - 30);
  }
  EXPECT_NEAR(std::sqrt(momentsOf(errors[0]).variance), 0.04, 0.002);
  EXPECT_NEAR(std::sqrt(momentsOf(errors[1]).variance), 0.04 * std::sqrt(2.0), 0.003);
}

}  // namespace
}  // namespace scanmill
