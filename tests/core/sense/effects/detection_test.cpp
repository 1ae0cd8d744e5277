#include <map>

#include "sensors/footprint.h"
#include "tests/core/sense/several_returns.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

// A wall of power 1 at 10 m.
World wall() {
  World world = makeWorld(64, 400);
  world.beams().minRange = 1;
  world.beams().maxRange = 101;
  world.beams().pulse = 2 * 0.5 / kLightSpeed;  // 200 stretches of half a metre
  return world;
}

double tail(double x) {
  return 0.5 * std::erfc(x / std::sqrt(2.0));
}

std::string detection(double noise, double threshold) {
  return "detection: {returns: all, noise: " + std::to_string(noise) + ", threshold: " + std::to_string(threshold) +
         "}";
}

TEST(Detection, FindsAsOftenAsTheNormalLawSays) {
  const World world = wall();
  for (const double snr : {3.0, 5.0, 6.0, 8.0}) {
    const Returns returns = run(world, {"intensity: {falloff: none}", detection(1 / snr, 5)});
    std::size_t found = 0;
    for (std::size_t row = 0; row < world.hits.size(); ++row) {
      found += returns.returned(row) ? 1 : 0;
      ASSERT_NEAR(returns.snr[row], snr, 1e-4);
    }
    const double n = static_cast<double>(world.hits.size());
    const double p = tail(5 - snr);
    EXPECT_NEAR(static_cast<double>(found), n * p, 4 * std::sqrt(n * p * (1 - p)) + 1) << snr;
  }
}

TEST(Detection, TakesNoiseForReturnsAsOftenAsTheNormalLawSays) {
  World world = wall();
  for (std::size_t beam = 0; beam < world.hits.size(); ++beam) miss(world, beam);
  const Returns returns = run(world, {"intensity: {}", detection(0.01, 3)});
  const double n = static_cast<double>(world.hits.size());
  const double p = 1 - std::exp(-200 * tail(3));
  std::vector<double> ranges;
  for (std::size_t row = 0; row < returns.size(); ++row) {
    if (!returns.returned(row)) continue;
    EXPECT_EQ(returns.cause(row), Reason::FalsePositive);
    EXPECT_EQ(returns.hit(row), kNoHit);
    EXPECT_GE(returns.power[row], 0.03f * 0.999f);
    ranges.push_back(returns.range[row]);
  }
  EXPECT_NEAR(static_cast<double>(ranges.size()), n * p, 4 * std::sqrt(n * p * (1 - p)));
  const Moments m = momentsOf(ranges);
  EXPECT_NEAR(m.mean, 51, 4 * 100 / std::sqrt(12.0 * static_cast<double>(ranges.size())));
  EXPECT_NEAR(m.variance, 100 * 100 / 12.0, 60);
}

TEST(Detection, WithoutNoiseFindsEverything) {
  const World world = makeRaggedWorld(16, 100);
  const Returns returns = run(world, {"intensity: {}", "detection: {}"});
  EXPECT_TRUE(returns.onePerBeam());
  EXPECT_EQ(returns.range, world.hits.range);
}

// Ranges and powers of one beam's returns that are reported.
std::map<float, float> reported(const std::string& yaml) {
  World world = makeWorld(1, 1);
  Hits& hits = world.hits;
  hits = Hits{};
  hits.rings = hits.columns = 1;
  hits.channels = Channels::all();
  for (const auto& [range, reflectance] : std::map<float, float>{{10, 0.3f}, {11, 0.8f}, {20, 0.5f}, {30, 0.1f}}) {
    hits.beamOfRay.push_back(0);
    hits.weightOfRay.push_back(1);
    hits.range.push_back(range);
    hits.normal.push_back({});
    hits.instance.push_back(0);
    hits.semantic.push_back(1);
    hits.material.push_back(0);
    hits.primitive.push_back(0);
    hits.reflectance.push_back(reflectance);
    hits.incidence.push_back(1);
  }
  const Returns returns = run(world, {"intensity: {falloff: none}", yaml});
  std::map<float, float> kept;
  for (std::size_t row = 0; row < returns.size(); ++row) {
    if (returns.returned(row)) kept[returns.range[row]] = returns.power[row];
  }
  return kept;
}

std::vector<float> rangesOf(const std::string& yaml) {
  std::vector<float> ranges;
  for (const auto& [range, power] : reported(yaml)) ranges.push_back(range);
  return ranges;
}

TEST(Detection, ReportsWhatItIsAskedFor) {
  using Ranges = std::vector<float>;
  EXPECT_EQ(rangesOf("detection: {}"), Ranges({11}));
  EXPECT_EQ(rangesOf("detection: {returns: strongest}"), Ranges({11}));
  EXPECT_EQ(rangesOf("detection: {returns: first}"), Ranges({10}));
  EXPECT_EQ(rangesOf("detection: {returns: last}"), Ranges({30}));
  EXPECT_EQ(rangesOf("detection: {returns: dual}"), Ranges({11, 30}));
  EXPECT_EQ(rangesOf("detection: {returns: 2}"), Ranges({11, 20}));
  EXPECT_EQ(rangesOf("detection: {returns: 3}"), Ranges({10, 11, 20}));
  EXPECT_EQ(rangesOf("detection: {returns: all}"), Ranges({10, 11, 20, 30}));
  EXPECT_EQ(rangesOf("detection: {returns: all, min_separation_m: 2}"), Ranges({11, 20, 30}));
  EXPECT_EQ(rangesOf("detection: {returns: first, min_separation_m: 2}"), Ranges({11}));
  EXPECT_EQ(rangesOf("detection: {returns: dual, min_separation_m: 15}"), Ranges({11, 30}));
  EXPECT_EQ(rangesOf("detection: {returns: dual, min_separation_m: 20}"), Ranges({11}));
}

TEST(Detection, BoundsTheReturnsOfABeam) {
  const auto most = [](const std::string& yaml, std::uint32_t before) { return makeEffect(yaml)->mostReturns(before); };
  EXPECT_EQ(most("footprint: {rays: 7}", 1), 7u);
  EXPECT_EQ(most("footprint: {rays: 127}", 1), 16u);
  EXPECT_EQ(most("detection: {}", 16), 1u);
  EXPECT_EQ(most("detection: {returns: dual}", 16), 2u);
  EXPECT_EQ(most("detection: {returns: all}", 7), 7u);
  EXPECT_EQ(most("detection: {returns: all, noise: 0.1}", 1), 2u);
  EXPECT_EQ(most("detection: {returns: 3}", 1), 1u);
}

TEST(Detection, RefusesBadOptions) {
  BeamTable beams;
  beams.divergence = {0.003, 0.003};
  EXPECT_THAT(messageOf([&] { makeEffect("footprint: {rays: 7}")->check(beams); }), HasSubstr("pulse_ns"));
  EXPECT_THAT(messageOf([&] { makeEffect("detection: {noise: 0.1}")->check(beams); }), HasSubstr("pulse_ns"));
  beams.pulse = 5e-9;
  makeEffect("footprint: {rays: 7}")->check(beams);
  beams.divergence = {};
  EXPECT_THAT(messageOf([&] { makeEffect("footprint: {rays: 7}")->check(beams); }), HasSubstr("divergence_mrad"));
}

}  // namespace
}  // namespace scanmill
