#include "config/distribution.h"

#include <fmt/core.h>

#include <numbers>

#include "base/random.h"
#include "config/fields.h"
#include "tests/support/message_of.h"

namespace scanmill {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Key;

constexpr std::size_t kSeeds = 4000;
// Kolmogorov's bound on the greatest distance of two distributions, which chance exceeds once in 100,000.
const double kChance = 2.47 / std::sqrt(static_cast<double>(kSeeds));

std::string drawnText(const std::string& yaml, std::uint64_t seed, const std::string& key = "k") {
  std::vector<DrawnValue> draws;
  return flowText(withDraws(parseYaml(yaml, "x.yaml"), key, {.seed = seed}, draws));
}

// In ascending order, one for each seed.
std::vector<double> numbersOf(const std::string& yaml) {
  std::vector<double> numbers;
  for (std::size_t seed = 0; seed < kSeeds; ++seed) numbers.push_back(std::stod(drawnText(yaml, seed)));
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

template <class Share>
double distanceFrom(const Share& shareBelow, const std::vector<double>& sorted) {
  double distance = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(sorted.size());
    distance = std::max(distance, std::abs(shareBelow(sorted[i]) - share));
  }
  return distance;
}

double normalBelow(double deviations) {
  return std::erfc(-deviations / std::numbers::sqrt2) / 2;
}

std::string refusal(const std::string& yaml) {
  return messageOf([&] { drawnText(yaml, 1); });
}

TEST(Distribution, UniformNumbersFillTheirInterval) {
  const std::vector<double> numbers = numbersOf("{uniform: [-2, 6]}");
  EXPECT_GE(numbers.front(), -2);
  EXPECT_LE(numbers.back(), 6);
  EXPECT_LT(distanceFrom([](double x) { return (x + 2) / 8; }, numbers), kChance);
}

TEST(Distribution, NormalNumbersHaveTheirMeanAndDeviation) {
  const std::vector<double> numbers = numbersOf("{normal: [10, 3]}");
  EXPECT_LT(distanceFrom([](double x) { return normalBelow((x - 10) / 3); }, numbers), kChance);
  EXPECT_GE(numbers.front(), -2);
  EXPECT_LE(numbers.back(), 22);
}

TEST(Distribution, NormalNumbersAreCutOff) {
  const std::vector<double> numbers = numbersOf("{normal: [1, 0.5], within: [0.75, 20]}");
  EXPECT_GE(numbers.front(), 0.75);
  EXPECT_LE(numbers.back(), 3);
  const double below = normalBelow(-0.5);
  EXPECT_LT(distanceFrom([&](double x) { return (normalBelow((x - 1) / 0.5) - below) / (1 - below); }, numbers),
            kChance);
}

TEST(Distribution, EachOfAChoiceIsAsLikely) {
  std::map<std::string, int> counts;
  for (std::size_t seed = 0; seed < kSeeds; ++seed) ++counts[drawnText("{choice: [summer, [1, 2], 3.5]}", seed)];
  EXPECT_THAT(counts, ElementsAre(Key("3.5"), Key("[1, 2]"), Key("summer")));
  const double mean = kSeeds / 3.0;
  for (const auto& [text, count] : counts) EXPECT_NEAR(count, mean, 5 * std::sqrt(mean * 2 / 3)) << text;
}

// Shares are those of the weights, within four standard deviations; an item of weight 0 never occurs.
TEST(Distribution, WeightsOfAChoice) {
  std::map<std::string, std::size_t> counts;
  for (std::size_t seed = 0; seed < kSeeds; ++seed) {
    ++counts[drawnText("{choice: [wet, dry, icy, 7], weights: [1, 8, 0, 1]}", seed)];
  }
  const auto n = static_cast<double>(kSeeds);
  for (const auto& [item, share] : std::map<std::string, double>{{"wet", 0.1}, {"dry", 0.8}, {"7", 0.1}}) {
    EXPECT_NEAR(static_cast<double>(counts[item]), n * share, 4 * std::sqrt(n * share * (1 - share))) << item;
  }
  EXPECT_EQ(counts.count("icy"), 0u);
  EXPECT_EQ(drawnText("{choice: [1, ..., 3], weights: [0, 0, 2]}", 5), "3");
}

TEST(Distribution, AChoiceOfIntegersMayBeASpan) {
  std::map<int, int> counts;
  for (std::size_t seed = 0; seed < kSeeds; ++seed) ++counts[std::stoi(drawnText("{choice: [1, ..., 9, 20]}", seed))];
  EXPECT_THAT(counts, ElementsAre(Key(1), Key(2), Key(3), Key(4), Key(5), Key(6), Key(7), Key(8), Key(9), Key(20)));
}

TEST(Distribution, AChoiceMayBeAmongDistributions) {
  std::vector<double> some;
  for (std::size_t seed = 0; seed < 2 * kSeeds; ++seed) {
    const double x = std::stod(drawnText("{choice: [0, {uniform: [0.5, 2]}]}", seed));
    if (x != 0) some.push_back(x);
  }
  EXPECT_NEAR(static_cast<double>(some.size()), kSeeds, 5 * std::sqrt(kSeeds / 2.0));
  std::sort(some.begin(), some.end());
  EXPECT_LT(distanceFrom([](double x) { return (x - 0.5) / 1.5; }, some), kChance);
}

TEST(Distribution, KeysAreToldAsOverridesNameThem) {
  std::vector<DrawnValue> draws;
  const Value file = parseYaml(
      "objects:\n"
      "  - {town: {length: {uniform: [200, 400]}, slope: 1}}\n"
      "  - {position: [0, {normal: [3, 1]}, 2], color: {choice: [{at: [1, {choice: [0.5]}], tone: {choice: "
      "[red]}}]}}\n",
      "x.yaml");
  EXPECT_TRUE(holdsDistribution(file));
  Value written = withDraws(file, "", {.seed = 7}, draws);
  EXPECT_FALSE(holdsDistribution(written));
  ASSERT_EQ(draws.size(), 5U);
  EXPECT_EQ(draws[0].key, "objects.0.town.length");
  EXPECT_EQ(draws[1].key, "objects.1.position.1");
  EXPECT_EQ(draws[2], (DrawnValue{"objects.1.color.at.0", "1", true}));
  EXPECT_EQ(draws[3], (DrawnValue{"objects.1.color.at.1", "0.5", true}));
  EXPECT_EQ(draws[4], (DrawnValue{"objects.1.color.tone", "red"}));
  Value set = file;
  setValue(set, "objects.1.color={at: [0, 0]}");  // in place of the distribution, whose values follow
  for (const DrawnValue& d : draws) setValue(set, d.key + "=" + d.value);
  EXPECT_EQ(flowText(set), flowText(written));
}

TEST(Distribution, AValueStaysTheSameWhateverElseTheFileHas) {
  const std::string alone = drawnText("{a: {uniform: [0, 1]}}", 3);
  const std::string beside = drawnText("{b: {uniform: [0, 1]}, a: {uniform: [0, 1]}}", 3);
  EXPECT_THAT(beside, HasSubstr(alone.substr(1, alone.size() - 2)));
}

TEST(Distribution, KeysAreIndependent) {
  double sum = 0;
  for (std::size_t seed = 0; seed < kSeeds; ++seed) {
    sum += (std::stod(drawnText("{uniform: [0, 1]}", seed, "a")) - 0.5) *
           (std::stod(drawnText("{uniform: [0, 1]}", seed, "b")) - 0.5) * 12;
  }
  EXPECT_LT(std::abs(sum / kSeeds), 5 / std::sqrt(static_cast<double>(kSeeds)));
}

TEST(Distribution, WhatIsDrawnPerFrameDiffersFromFrameToFrameAndAllElseDoesNot) {
  const Value value =
      parseYaml("{a: {uniform: [0, 1], per: frame}, b: {uniform: [0, 1]}, c: [{choice: [1, 2]}]}", "x.yaml");
  ASSERT_NE(findDrawnPerFrame(value), nullptr);
  EXPECT_EQ(findDrawnPerFrame(value), value.find("a"));
  EXPECT_EQ(findDrawnPerFrame(*value.find("b")), nullptr);
  std::set<std::string> perFrame;
  std::set<std::string> perSequence;
  for (std::uint32_t frame = 0; frame < 50; ++frame) {
    std::vector<DrawnValue> draws;
    withDraws(value, "", {.seed = 3, .scene = 2, .frame = frame}, draws);
    ASSERT_EQ(draws.size(), 3U);
    perFrame.insert(draws[0].value);
    perSequence.insert(draws[1].value + draws[2].value);
  }
  EXPECT_EQ(perFrame.size(), 50U);
  EXPECT_EQ(perSequence.size(), 1U);
}

// The items occur n p times, rounded up or down, in random order: the law of `stratify: split`. Numbers are at equal
// distances.
TEST(Distribution, StratifiedValuesAreSpreadEvenly) {
  const auto drawn = [](const std::string& yaml, std::uint64_t index, std::uint64_t count, const std::string& split) {
    std::vector<DrawnValue> draws;
    const PlaceInSplit strata{split, index, count, 0, 1};
    return flowText(withDraws(parseYaml(yaml, "x.yaml"), "k", {.seed = 7, .scene = 3}, draws, strata));
  };
  std::set<std::string> orders;
  for (const std::uint64_t n : {1u, 2u, 3u, 7u, 12u, 100u}) {
    for (const char* split : {"train", "val", "test"}) {
      std::map<std::string, double> counts;
      std::string order;
      std::vector<double> numbers;
      for (std::uint64_t i = 0; i < n; ++i) {
        order += drawn("{choice: [d, r, f], weights: [6, 3, 1], stratify: split}", i, n, split);
        ++counts[order.substr(i)];
        numbers.push_back(std::stod(drawn("{uniform: [0, 1], stratify: split}", i, n, split)));
      }
      orders.insert(order);
      for (const auto& [item, share] : std::map<std::string, double>{{"d", 0.6}, {"r", 0.3}, {"f", 0.1}}) {
        EXPECT_LT(std::abs(counts[item] - static_cast<double>(n) * share), 1 + 1e-9) << n << split << item;
      }
      std::sort(numbers.begin(), numbers.end());
      for (std::size_t i = 1; i < n; ++i) {
        EXPECT_NEAR(numbers[i] - numbers[i - 1], 1 / static_cast<double>(n), 1e-9) << "a permutation";
      }
    }
  }
  EXPECT_GT(orders.size(), 12u);
  EXPECT_THAT(refusal("{uniform: [0, 1], stratify: frame}"), HasSubstr("split"));
}

TEST(Distribution, CasesReachAllEndsAndItems) {
  const Value value = parseYaml(
      "{a: {uniform: [1, 2]}, b: {choice: [x, {normal: [0, 1], within: [-1, 9]}, [{uniform: [5, 6]}]]}, c: {choice: "
      "[7, ..., 9]}}",
      "x.yaml");
  ASSERT_EQ(countCases(value), 6U);
  std::map<std::string, std::set<std::string>> met;
  for (std::size_t number = 0; number < 6; ++number) {
    const Value one = withCase(value, number);
    EXPECT_FALSE(holdsDistribution(one));
    for (const Value::Entry& entry : one.entries) met[entry.key].insert(flowText(entry.value));
  }
  EXPECT_THAT(met["a"], ElementsAre("1", "2"));
  EXPECT_THAT(met["b"], ElementsAre("-1", "4", "[5]", "[6]", "x"));
  EXPECT_THAT(met["c"], ElementsAre("7", "9"));
  EXPECT_EQ(countCases(parseYaml("[1, {a: 2}]", "x.yaml")), 1U);
}

TEST(Distribution, OtherMapsAreNone) {
  const std::string text = "{a: [1, {b: 2}], within: [0, 1]}";
  EXPECT_FALSE(holdsDistribution(parseYaml(text, "x.yaml")));
  EXPECT_EQ(drawnText(text, 1), text);
}

TEST(Distribution, RefusesWhatIsNone) {
  EXPECT_THAT(refusal("{uniform: [2, 1]}"), AllOf(HasSubstr("x.yaml:1:"), HasSubstr("[least, most]")));
  EXPECT_THAT(refusal("{uniform: [1, 1]}"), HasSubstr("[least, most]"));
  EXPECT_THAT(refusal("{uniform: 3}"), HasSubstr("uniform"));
  EXPECT_THAT(refusal("{uniform: [0, .inf]}"), HasSubstr("uniform"));
  EXPECT_THAT(refusal("{normal: [0, 0]}"), HasSubstr("above 0"));
  EXPECT_THAT(refusal("{normal: [0, 1, 2]}"), HasSubstr("[mean, standard deviation]"));
  EXPECT_THAT(refusal("{normal: [0, 1], within: [5, 6]}"), HasSubstr("within excludes all values of the distribution"));
  EXPECT_THAT(refusal("{uniform: [0, 1], within: [0, 1]}"), HasSubstr("normal"));
  EXPECT_THAT(refusal("{uniform: [0, 1], normal: [0, 1]}"), HasSubstr("one of"));
  EXPECT_THAT(refusal("{choice: []}"), HasSubstr("at least one"));
  EXPECT_THAT(refusal("{choice: [a, ..., b]}"), HasSubstr("choice"));
  for (const char* weights : {"[1]", "[0, 0]", "[1, -1]", "[1, 2, 3]"}) {
    EXPECT_THAT(refusal(std::string("{choice: [a, b], weights: ") + weights + "}"),
                HasSubstr("weights must be 2 numbers of at least 0"))
        << weights;
  }
  EXPECT_THAT(refusal("{uniform: [0, 1], weights: [1]}"), HasSubstr("only be given to a choice"));
  EXPECT_THAT(refusal("{uniform: [0, 1], per: scan}"), HasSubstr("frame"));
  EXPECT_THAT(messageOf([] { readNumber(parseYaml("{uniform: [0, 1]}", "x.yaml"), "speed"); }),
              AllOf(HasSubstr("x.yaml:1:"), HasSubstr("speed cannot be random"), HasSubstr("--set")));
  EXPECT_THAT(refusal("{uniform: [0, 1], wihtin: [0, 1]}"), HasSubstr("within"));
}

}  // namespace
}  // namespace scanmill
