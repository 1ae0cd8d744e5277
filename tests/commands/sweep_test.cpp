// Datasets of several values of a key, and of all corruptions.

#include "commands/sweep.h"

#include <set>

#include "dataset/manifest.h"
#include "pipeline/read/effects.h"
#include "tests/commands/program.h"

namespace scanmill {
namespace {

using testing::HasSubstr;

class Sweep : public SmallWorld {};

// Each set is what --set alone makes, and its samples bear the same keys as the others'.
TEST_F(Sweep, ASweepMakesASetForEachCombination) {
  const std::vector<std::string> sweep{"generate",  pipeline_,    "-o",
                                       at("sweep"), "--sweep",    "effects=[[], [range_noise: {sigma_m: 0.02}]]",
                                       "--sweep",   "seed=[3, 4]"};
  const Outcome made = scanmill(sweep);
  ASSERT_EQ(made.code, 0) << made.error;
  const std::vector<std::pair<std::string, std::vector<std::string>>> expected{
      {"effects=none,seed=3", {"effects=[]", "seed=3"}},
      {"effects=none,seed=4", {"effects=[]", "seed=4"}},
      {"effects=range_noise-sigma_m-0.02,seed=3", {"effects=[range_noise: {sigma_m: 0.02}]", "seed=3"}},
      {"effects=range_noise-sigma_m-0.02,seed=4", {"effects=[range_noise: {sigma_m: 0.02}]", "seed=4"}}};
  std::vector<std::string> keys;
  for (const auto& [name, overrides] : expected) {
    EXPECT_THAT(made.out, HasSubstr("of 4: " + at("sweep/" + name) + "\n"));
    ASSERT_EQ(scanmill({"generate", pipeline_, "-o", at("alone"), "--overwrite", "-q", "--set", overrides[0], "--set",
                        overrides[1]})
                  .code,
              0);
    const Manifest own = readManifest(at("sweep/" + name)), alone = readManifest(at("alone"));
    ASSERT_EQ(own.shards.size(), alone.shards.size());
    for (std::size_t i = 0; i < own.shards.size(); ++i) EXPECT_EQ(own.shards[i].sha256, alone.shards[i].sha256);
    EXPECT_THAT(own.pipelineText, HasSubstr("# --set seed="));
    std::vector<std::string> names;
    for (const SampleRecord& sample : own.samples) names.push_back(sample.key);
    if (keys.empty()) keys = names;
    EXPECT_EQ(names, keys);
  }
  std::vector<std::string> again = sweep;
  again.emplace_back("--resume");
  const Outcome whole = scanmill(again);
  EXPECT_EQ(whole.code, 0);
  EXPECT_THAT(whole.out, HasSubstr("effects=none,seed=4: is complete: there is nothing to resume"));
}

TEST_F(Sweep, FoldersTellKeysApartThatEndAlike) {
  const std::vector<SweepSet> sets = sweepSets({"sensors.0.columns=[64]", "sensors.1.columns=[32]", "seed=[1]"});
  EXPECT_EQ(sets.at(0).folder, "sensors.0.columns=64,sensors.1.columns=32,seed=1");
}

// The list has each corruption in each severity, and none; a set of it is named in words.
TEST_F(Sweep, CorruptionsAreASweep) {
  const std::vector<SweepSet> sets = sweepSets({corruptionSweep()});
  EXPECT_EQ(sets.size(), 1 + 3 * corruptionNames().size());
  EXPECT_EQ(sets.front().folder, "corruption=null");
  std::set<std::string> folders;
  for (const SweepSet& set : sets) folders.insert(set.folder);
  EXPECT_TRUE(folders.contains("corruption=lost_rings-heavy"));
}

}  // namespace
}  // namespace scanmill
