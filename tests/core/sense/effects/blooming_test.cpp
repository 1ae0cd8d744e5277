#include "sensors/footprint.h"
#include "tests/core/sense/several_returns.h"

namespace scanmill {
namespace {

// 5 rings 15 deg apart, 720 columns half a degree apart: a sign of 200 white targets at 10 m in the middle of ring 2,
// around it a wall at 30 m.
World sign() {
  World world = makeWorld(5, 720, 30);
  world.beams().maxRange = 100;
  world.beams().pulse = 5e-9;
  world.materials.resize(2);
  world.materials[1].retroreflectance = 200;
  const std::size_t beam = 2 * 720 + 360;
  world.hits.range[beam] = 10;
  world.hits.material[beam] = 1;
  world.hits.incidence[beam] = 0.5f;
  return world;
}

struct StrayReturn {
  std::uint32_t beam;
  float range;
  float power;
};

std::vector<StrayReturn> strays(const World& world, const std::vector<std::string>& effects) {
  const Returns returns = run(world, effects);
  std::vector<StrayReturn> found;
  for (std::uint32_t row = 0; row < returns.size(); ++row) {
    if (returns.cause(row) != Reason::StrayLight || !returns.returned(row)) continue;
    EXPECT_EQ(returns.hit(row), kNoHit);
    found.push_back({returns.beam(row), returns.range[row], returns.power[row]});
  }
  return found;
}

TEST(Blooming, BeamsBesideARetroreflectorReturnFromItsRange) {
  const auto found = strays(sign(), {"blooming: {share: 0.01, angle_deg: 1}", "intensity: {}"});
  ASSERT_EQ(found.size(), 8u) << "within two degrees, half a degree apart, on both sides";
  for (const StrayReturn& stray : found) {
    EXPECT_EQ(stray.range, 10);
    const double angle = std::abs(static_cast<double>(stray.beam) - (2 * 720 + 360)) * 0.5;
    EXPECT_NEAR(stray.power, 200 * 0.5 * 0.01 * std::exp(-2 * angle * angle), 1e-4) << angle;
  }
}

TEST(Blooming, TheStrongestOfSeveralStays) {
  World world = sign();
  world.hits.range[2 * 720 + 363] = 12;
  world.hits.material[2 * 720 + 363] = 1;
  world.hits.incidence[2 * 720 + 363] = 1;
  const auto found = strays(world, {"blooming: {share: 0.01, angle_deg: 1}", "intensity: {}"});
  EXPECT_GE(found.size(), 10u) << "each of the two signs, and what lies within two degrees of either";
  for (const StrayReturn& stray : found) {
    const double from = 0.5 * (static_cast<double>(stray.beam) - (2 * 720 + 360));
    const double first = from == 0 ? 0 : 100 * std::exp(-2 * from * from);
    const double second = from == 1.5 ? 0 : 200 * std::exp(-2 * (from - 1.5) * (from - 1.5));
    EXPECT_EQ(stray.range, first > second ? 10 : 12) << from;
  }
}

TEST(Blooming, JoinsAnEchoThatIsThereAndSparesWhatIsMatt) {
  World near = sign();
  std::fill(near.hits.range.begin(), near.hits.range.end(), 10.5f);
  near.hits.range[2 * 720 + 360] = 10;
  EXPECT_TRUE(strays(near, {"blooming: {}", "intensity: {}"}).empty()) << "half a metre apart, a pulse is 0.75 m long";
  World matt = sign();
  matt.materials[1].retroreflectance = 5;
  EXPECT_TRUE(strays(matt, {"blooming: {}", "intensity: {}"}).empty());
}

TEST(Blooming, GoesRoundWithTheSensor) {
  World world = sign();
  std::swap(world.hits.range[2 * 720 + 360], world.hits.range[2 * 720]);
  std::swap(world.hits.material[2 * 720 + 360], world.hits.material[2 * 720]);
  const auto found = strays(world, {"blooming: {share: 0.01, angle_deg: 1}", "intensity: {}"});
  EXPECT_EQ(found.size(), 8u);
  std::size_t before = 0;
  for (const StrayReturn& stray : found) before += stray.beam > 2 * 720 + 360 ? 1 : 0;
  EXPECT_EQ(before, 4u);
}

TEST(RangeWalk, StrongReturnsSeemNearer) {
  World world = makeWorld(1, 3, 10);
  world.beams().minRange = 1;
  world.hits.reflectance = {1, 0.5f, 1};
  world.materials[0].retroreflectance = 99;
  const Returns returns = run(world, {"intensity: {}", "range_walk: {per_decade_m: 0.02}"});
  EXPECT_NEAR(returns.range[0], 10 - 0.02 * 2, 1e-5) << "a hundred times a white target";
  EXPECT_NEAR(returns.range[1], 10 - 0.02 * std::log10(99.5), 1e-5);
  world.materials[0].retroreflectance = 0;
  EXPECT_EQ(run(world, {"intensity: {}", "range_walk: {per_decade_m: 0.02}"}).range[1], 10);
}

TEST(Daylight, SunlitBrightSurfacesAreLostEarlier) {
  World world = makeWorld(64, 400);
  world.beams().minRange = 1;
  world.beams().maxRange = 101;
  world.beams().pulse = 5e-9;
  for (std::size_t beam = 0; beam < world.hits.size(); ++beam) {
    world.hits.normal[beam] = {0, 0, beam % 2 == 0 ? 1.0f : -1.0f};
    world.hits.reflectance[beam] = 0.5f;
  }
  // A power of 0.5, noise 0.1; of what faces the sun sqrt(0.1^2 + 0.2^2 * 0.5 * sin 30 deg) = 0.1414.
  const Returns returns = run(world, {"intensity: {falloff: none}",
                                      "detection: {returns: all, noise: 0.1, threshold: 4, sun: {azimuth_deg: 70, "
                                      "elevation_deg: 30, noise: 0.2}}"});
  double found[2] = {0, 0};
  for (std::size_t row = 0; row < world.hits.size(); ++row) {
    found[row % 2] += returns.returned(row) ? 1 : 0;
    ASSERT_NEAR(returns.snr[row], row % 2 == 0 ? 0.5 / std::sqrt(0.02) : 5.0, 1e-4);
  }
  const auto tail = [](double x) { return 0.5 * std::erfc(x / std::sqrt(2.0)); };
  const double n = static_cast<double>(world.hits.size()) / 2;
  EXPECT_NEAR(found[0] / n, tail(4 - 0.5 / std::sqrt(0.02)), 0.02);
  EXPECT_NEAR(found[1] / n, tail(4 - 5.0), 0.02);
}

TEST(Interference, IsAsRareAsItsProbability) {
  World world = makeWorld(64, 1000);
  world.beams().minRange = 1;
  world.beams().maxRange = 101;
  world.beams().pulse = 5e-9;
  for (std::size_t beam = 0; beam < world.hits.size(); ++beam) miss(world, beam);
  const auto found =
      strays(world, {"intensity: {}", "detection: {returns: all, noise: 0.001, threshold: 8, interference: 0.01}"});
  const double n = static_cast<double>(world.hits.size());
  EXPECT_NEAR(static_cast<double>(found.size()), n * 0.01, 4 * std::sqrt(n * 0.01));
  std::vector<double> ranges;
  for (const StrayReturn& stray : found) {
    ranges.push_back(stray.range);
    EXPECT_GE(stray.power, 0.008f * 0.999f);
    EXPECT_LE(stray.power, 0.8f * 1.001f);
  }
  EXPECT_NEAR(momentsOf(ranges).mean, 51, 4 * 100 / std::sqrt(12.0 * static_cast<double>(found.size())));
}

}  // namespace
}  // namespace scanmill
