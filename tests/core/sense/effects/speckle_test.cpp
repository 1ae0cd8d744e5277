#include "tests/core/sense/several_returns.h"

namespace scanmill {
namespace {

std::string looks(int n) {
  return "speckle: {looks: " + std::to_string(n) + "}";
}

// Of the gamma law with shape L and mean 1: variance 1 / L, skewness 2 / sqrt(L), kurtosis 3 + 6 / L.
TEST(Speckle, FollowsTheGammaLaw) {
  const World world = makeWorld(256, 2048);
  for (const int n : {1, 3, 4, 12, 30}) {
    const Returns returns = run(world, {looks(n), "intensity: {}"});
    const Moments m = momentsOf({returns.power.begin(), returns.power.end()});
    const double count = static_cast<double>(world.hits.size());
    EXPECT_NEAR(m.mean, 1, 5 / std::sqrt(n * count)) << n;
    EXPECT_NEAR(m.variance * n, 1, 5 * std::sqrt((2 + 6.0 / n) / count)) << n;
    EXPECT_NEAR(m.skewness, 2 / std::sqrt(n), 0.05) << n;
    EXPECT_NEAR(m.kurtosis, 3 + 6.0 / n, 0.5) << n;
    for (const float power : returns.power) ASSERT_GT(power, 0) << n;
  }
}

TEST(Speckle, LeavesRangesAndMissesAlone) {
  const World world = makeRaggedWorld(16, 100);
  const Returns returns = run(world, {looks(12), "intensity: {}"});
  EXPECT_EQ(returns.range, world.hits.range);
  for (std::size_t b = 0; b < returns.size(); ++b) EXPECT_EQ(returns.intensity[b] > 0, world.hits.hit(b)) << b;
}

// Faint returns are lost by the power that arrives, speckle included.
TEST(Speckle, DecidesWhatIsTooFaint) {
  const World world = makeWorld(256, 1024);
  const Returns returns = run(world, {looks(1), "intensity: {}", "dropout: {threshold: 1}"});
  const auto lost = std::count(returns.range.begin(), returns.range.end(), kMiss);
  EXPECT_NEAR(static_cast<double>(lost) / static_cast<double>(returns.size()), 1 - std::exp(-1.0), 0.005);
}

TEST(Speckle, EachReturnOfABeamHasItsOwn) {
  const World world = makeSeveralReturns(32, 300);
  const Returns returns = run(world, {looks(4), "intensity: {falloff: none}"});
  std::vector<double> nearer;
  std::vector<double> farther;
  for (std::size_t row = 0; row + 1 < returns.size(); ++row) {
    if (returns.beam(row) != returns.beam(row + 1)) continue;
    nearer.push_back(returns.gain[row]);
    farther.push_back(returns.gain[row + 1]);
    EXPECT_FLOAT_EQ(returns.power[row], 0.5f * returns.gain[row]);
  }
  ASSERT_EQ(nearer.size(), 3200u);
  EXPECT_NEAR(correlation(nearer, farther), 0, 0.09);
}

}  // namespace
}  // namespace scanmill
