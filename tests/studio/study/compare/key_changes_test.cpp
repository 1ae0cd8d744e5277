#include <map>

#include "study/compare/compare.h"
#include "tests/studio/study/compare/compare_scans.h"

namespace scanmill {
namespace {

std::vector<Value> items(const std::string& list) {
  return parseYaml(list, "effects").items;
}

SetComparison compared(const Flaws& real, const Flaws& simulated) {
  return compareSets(setOf(real, 1), setOf(simulated, 11));
}

const std::string kOwn =
    "[speckle: {looks: 30}, ring_bias: {range_sigma_m: 0.08, gain_sigma: 0.3}, range_noise: {sigma_m: 0.02}]";

// What each key should be is known: what the first set has, of which the second has four times as much. Followed, the
// advice leaves less than half of the way, as a ratio.
TEST(CompareAdvice, LeadsToTheValueThatMadeTheOtherSet) {
  const Flaws real{.sigma = 0.005, .ringOffset = 0.02, .ringGain = 0.075, .speckle = 0.2};
  const Flaws simulated{.sigma = 0.02, .ringOffset = 0.08, .ringGain = 0.3, .speckle = 0.05};
  const std::vector<KeyChange> advice = adviceFor(compared(real, simulated), items(kOwn));
  for (const auto& [key, right] : std::map<std::string_view, double>{
           {"sigma_m", 0.005}, {"range_sigma_m", 0.02}, {"gain_sigma", 0.075}, {"looks", 30.0 / 16}}) {
    const auto found =
        std::ranges::find_if(advice, [&](const KeyChange& a) { return a.key.ends_with("." + std::string(key)); });
    ASSERT_NE(found, advice.end()) << key;
    EXPECT_LT(std::fabs(std::log(found->suggested / right)), std::fabs(std::log(found->current / right)) / 2) << key;
  }
}

// Effects that are absent, keys that are lists, tables or distributions.
TEST(CompareAdvice, IsNoneWhereNothingDiffersOrNoNumberScalesIt) {
  EXPECT_THAT(adviceFor(compared({}, {}), items(kOwn)), testing::IsEmpty());
  const Flaws otherRings{.ringOffset = 0.065, .ringGain = 0.24};  // 32 rings: each draw has another spread by 18 %
  EXPECT_THAT(adviceFor(compared({.ringOffset = 0.08, .ringGain = 0.3}, otherRings), items(kOwn)), testing::IsEmpty());
  const SetComparison differ = compared({.sigma = 0.005, .speckle = 0.2}, {.sigma = 0.02, .speckle = 0.05});
  EXPECT_THAT(adviceFor(differ, {}), testing::IsEmpty());
  EXPECT_THAT(
      adviceFor(differ, items("[range_noise: {table: [[5, 0.01], [20, 0.02]]}, speckle: {looks: {uniform: [5, 9]}}]")),
      testing::IsEmpty());
}

TEST(CompareAdvice, IsAnOptionForThePipelinesOwnList) {
  const std::vector<KeyChange> advice{{.key = "ring_bias.gain_sigma", .suggested = 0.15},
                                      {.key = "relief.strength", .suggested = 0.5}};
  EXPECT_EQ(assignmentOf(advice, items("[sensor, relief, light_paths]")),
            "effects=[sensor, {relief: {strength: 0.5}}, light_paths, {ring_bias: {gain_sigma: 0.15}}]");
  EXPECT_EQ(assignmentOf(advice, items("[ring_bias: {range_sigma_m: 0.1, gain_sigma: 0.3}, relief: {strength: 1}]")),
            "effects=[{ring_bias: {range_sigma_m: 0.1, gain_sigma: 0.15}}, {relief: {strength: 0.5}}]");
}

}  // namespace
}  // namespace scanmill
