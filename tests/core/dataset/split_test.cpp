#include "dataset/split.h"

#include <map>
#include <set>

#include "base/error.h"
#include "tests/core/dataset/fixture.h"

namespace scanmill {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::HasSubstr;

// Two scenes and two trajectories for each seed.
std::vector<SequenceName> sequencesOf(std::uint64_t seeds) {
  std::vector<SequenceName> sequences;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    for (const char* scene : {"street", "town"}) {
      for (const char* trajectory : {"north", "south"}) sequences.push_back({scene, seed, trajectory});
    }
  }
  return sequences;
}

std::vector<std::string> assign(const std::string& yaml, const std::vector<SequenceName>& sequences,
                                std::uint64_t seed = 1) {
  const Value value = parseYaml(yaml, "pipeline.yaml");
  return assignSplits(&value, sequences, seed);
}

std::map<std::string, int> countsOf(const std::vector<std::string>& splits) {
  std::map<std::string, int> counts;
  for (const std::string& split : splits) ++counts[split];
  return counts;
}

std::string refusalOfSplit(const std::string& yaml, std::uint64_t seeds) {
  return messageOf<InputError>([&] { assign(yaml, sequencesOf(seeds)); });
}

constexpr const char* kShares = "{by: seed, train: 0.8, val: 0.1, test: 0.1}";

TEST(Splits, DefaultIsTrain) {
  EXPECT_THAT(assignSplits(nullptr, sequencesOf(3), 1), Each("train"));
  const Value null;
  EXPECT_THAT(assignSplits(&null, sequencesOf(3), 1), Each("train"));
}

// Largest remainder: each split's number of groups is within one of its quota, and all groups are given.
TEST(Splits, SharesAreMetWithinOneGroup) {
  for (std::uint64_t groups = 10; groups < 120; ++groups) {
    const std::vector<std::string> splits = assign(kShares, sequencesOf(groups));
    const auto counts = countsOf(splits);
    for (const auto& [split, share] : std::map<std::string, double>{{"train", 0.8}, {"val", 0.1}, {"test", 0.1}}) {
      EXPECT_LT(std::abs(counts.at(split) / 4.0 - share * static_cast<double>(groups)), 1 - 1e-9) << groups << split;
    }
  }
  EXPECT_EQ(countsOf(assign(kShares, sequencesOf(30))),
            (std::map<std::string, int>{{"train", 96}, {"val", 12}, {"test", 12}}));
}

TEST(Splits, AGroupIsNeverParted) {
  const std::vector<SequenceName> sequences = sequencesOf(25);
  const auto expectWhole = [&]<class Group>(const std::vector<std::string>& splits, Group SequenceName::*group) {
    std::map<Group, std::set<std::string>> splitsOf;
    for (std::size_t i = 0; i < sequences.size(); ++i) splitsOf[sequences[i].*group].insert(splits[i]);
    for (const auto& [name, set] : splitsOf) EXPECT_EQ(set.size(), 1u) << name;
  };
  expectWhole(assign(kShares, sequences), &SequenceName::seed);
  const std::vector<std::string> byTrajectory = assign("{by: trajectory, train: 0.5, test: 0.5}", sequences);
  expectWhole(byTrajectory, &SequenceName::trajectory);
  EXPECT_EQ(countsOf(byTrajectory), (std::map<std::string, int>{{"train", 50}, {"test", 50}}));
}

TEST(Splits, DoNotDependOnTheOrderOfSequences) {
  std::vector<SequenceName> sequences = sequencesOf(20);
  std::vector<std::string> splits = assign(kShares, sequences);
  std::reverse(sequences.begin(), sequences.end());
  std::reverse(splits.begin(), splits.end());
  EXPECT_EQ(assign(kShares, sequences), splits);
}

// The published assignment: it may never change, or old and new datasets of one pipeline would leak into each other.
TEST(Splits, FollowFromTheSeedAlone) {
  std::vector<std::uint64_t> test;
  const std::vector<SequenceName> sequences = sequencesOf(20);
  const std::vector<std::string> splits = assign(kShares, sequences, 1);
  for (std::size_t i = 0; i < sequences.size(); i += 4) {
    if (splits[i] == "test") test.push_back(sequences[i].seed);
  }
  EXPECT_EQ(test, (std::vector<std::uint64_t>{16, 17}));
  EXPECT_NE(assign(kShares, sequences, 2), splits);
}

TEST(Splits, EverySeedIsAsLikelyInEverySplit) {
  std::map<std::uint64_t, int> inTest;
  const std::vector<SequenceName> sequences = sequencesOf(10);
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const std::vector<std::string> splits = assign(kShares, sequences, seed);
    for (std::size_t i = 0; i < splits.size(); i += 4) inTest[sequences[i].seed] += splits[i] == "test" ? 1 : 0;
  }
  for (const auto& [seed, count] : inTest) EXPECT_NEAR(count, 200, 5 * std::sqrt(2000 * 0.1 * 0.9)) << seed;
}

TEST(Splits, ListsAreTakenLiterally) {
  const auto splits = assign("{by: seed, train: [1, 3], val: [2], test: []}", sequencesOf(3));
  EXPECT_EQ(splits, (std::vector<std::string>{"train", "train", "train", "train", "val", "val", "val", "val", "train",
                                              "train", "train", "train"}));
  EXPECT_EQ(assign("{by: seed, train: [1, ..., 3], val: []}", sequencesOf(3)), std::vector<std::string>(12, "train"));
  const auto byName = assign("{by: trajectory, train: [north], test: [south]}", sequencesOf(1));
  EXPECT_EQ(byName, (std::vector<std::string>{"train", "test", "train", "test"}));
}

TEST(Splits, RefusesWhatCannotBe) {
  EXPECT_THAT(refusalOfSplit(kShares, 4), HasSubstr("test: a share of 0.1 of 4 seeds is less than one"));
  EXPECT_THAT(refusalOfSplit("{train: 0.5, val: 0.4}", 10), HasSubstr("sum of the shares is 0.9"));
  EXPECT_THAT(refusalOfSplit("{train: 1.5, val: -0.5}", 10), HasSubstr("pipeline.yaml:1"));
  EXPECT_THAT(refusalOfSplit("{by: seed}", 10),
              AllOf(HasSubstr("no train, val or test"), HasSubstr("--set splits=null")));
  EXPECT_THAT(refusalOfSplit("{by: frame, train: 1}", 10), HasSubstr("seed"));
  EXPECT_THAT(refusalOfSplit("{trian: 1}", 10), HasSubstr("train"));
  EXPECT_THAT(refusalOfSplit("{train: [1], val: 0.5}", 2), HasSubstr("either all shares or all lists"));
  EXPECT_THAT(refusalOfSplit("{train: [1], val: [1, 2]}", 2), HasSubstr("seed 1 is in 'train' already"));
  EXPECT_THAT(refusalOfSplit("{train: [1], val: [7]}", 2),
              HasSubstr("no sequence has the seed 7 (known: 1, 2); --set splits=null puts all sequences into train"));
  EXPECT_THAT(refusalOfSplit("{train: [1]}", 2), HasSubstr("seed 2 is in no list"));
  EXPECT_THAT(refusalOfSplit("{train: [one]}", 1), HasSubstr("pipeline.yaml:1"));
  EXPECT_THAT(refusalOfSplit("[train]", 1), HasSubstr("pipeline.yaml:1"));
  EXPECT_THAT(refusalOfSplit("{train: {a: 1}}", 1), HasSubstr("pipeline.yaml:1"));
}

}  // namespace
}  // namespace scanmill
