#include "pipeline/plan/shard_jobs.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <map>
#include <set>

#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

using testing::ElementsAre;

class ShardJobs : public Yard {
 protected:
  std::vector<ShardJob> jobs(const std::vector<std::string>& overrides) const {
    return shardJobs(makePlan(readPipeline(pipeline_, overrides)));
  }
  static std::vector<std::size_t> sizes(const std::vector<ShardJob>& jobs) {
    std::vector<std::size_t> found;
    for (const ShardJob& job : jobs) found.push_back(job.samples.size());
    return found;
  }
};

const std::vector<std::string> kThree{"scenes.0.seeds=[1, 2, 3]", "splits={by: seed, train: [1, 3], val: [2]}",
                                      "trajectories.0.frames=7"};

// Every sample is in one shard of its split, in the order of sequences and frames.
TEST_F(ShardJobs, HoldEverySampleOnce) {
  for (const std::string size : {"output.shard_samples=1", "output.shard_samples=4", "output.shard_samples=100",
                                 "output.shard_mb=1", "output.shard_mb=1000"}) {
    SCOPED_TRACE(size);
    std::vector<std::string> overrides = kThree;
    overrides.push_back(size);
    std::set<std::pair<std::size_t, std::uint32_t>> seen;
    std::map<std::string, std::pair<std::size_t, std::uint32_t>> last;
    std::set<std::string> files;
    for (const ShardJob& job : jobs(overrides)) {
      EXPECT_TRUE(files.insert(job.file).second) << job.file;
      EXPECT_FALSE(job.samples.empty());
      for (const SampleAddress& s : job.samples) {
        EXPECT_EQ(job.split, s.sequence == 1 ? "val" : "train");
        EXPECT_TRUE(seen.emplace(s.sequence, s.frame).second);
        const std::pair here{s.sequence, s.frame};
        if (last.contains(job.split)) {
          EXPECT_LT(last[job.split], here);
        }
        last[job.split] = here;
      }
    }
    EXPECT_EQ(seen.size(), 21u);
  }
}

// Shuffled, shards have the same sizes and splits, but every one holds samples of all parts of its split's sequences.
TEST_F(ShardJobs, SpreadSamplesAtRandom) {
  std::vector<std::string> overrides{"scenes.0.seeds=[1, 2, 3]", "splits={by: seed, train: [1, 3], val: [2]}",
                                     "trajectories.0.frames=400", "trajectories.0.every_s=1e-3",
                                     "output.shard_samples=100"};
  const std::vector<ShardJob> plain = jobs(overrides);
  overrides.emplace_back("output.shuffle=true");
  const std::vector<ShardJob> shuffled = jobs(overrides);
  EXPECT_EQ(sizes(shuffled), sizes(plain));
  std::set<std::uint64_t> seen;
  for (const ShardJob& job : shuffled) {
    double sum = 0;
    std::map<std::size_t, int> ofSequence;
    for (std::size_t i = 0; i < job.samples.size(); ++i) {
      const SampleAddress& s = job.samples[i];
      EXPECT_EQ(job.split, s.sequence == 1 ? "val" : "train");
      EXPECT_EQ(s.number, 400 * s.sequence + s.frame);
      EXPECT_TRUE(seen.insert(s.number).second);
      EXPECT_TRUE(i == 0 || s.number > job.samples[i - 1].number) << "in order within a shard";
      sum += s.frame;
      ++ofSequence[s.sequence];
    }
    // The mean of 100 of 400 frames: 199.5, with a standard deviation of 10.
    EXPECT_NEAR(sum / 100, 199.5, 50);
    for (const auto& [sequence, count] : ofSequence) EXPECT_GT(count, 25) << sequence;
  }
  EXPECT_EQ(seen.size(), 1200u);
  overrides.emplace_back("seed=99");
  EXPECT_NE(jobs(overrides)[0].samples[0].number + jobs(overrides)[0].samples[50].number,
            shuffled[0].samples[0].number + shuffled[0].samples[50].number);
}

TEST_F(ShardJobs, AreAsLargeAsAsked) {
  std::vector<std::string> overrides = kThree;
  overrides.emplace_back("output.shard_samples=4");
  EXPECT_THAT(sizes(jobs(overrides)), ElementsAre(4, 4, 4, 2, 4, 3));
  overrides.back() = "output.shard_mb=1000";
  EXPECT_THAT(sizes(jobs(overrides)), ElementsAre(7, 7, 3, 4)) << "at least two for each split";
  EXPECT_THAT(sizes(jobs({"trajectories.0.frames=1", "splits="})), ElementsAre(1));
  // The name of the last shard of each split follows from how many there are.
  EXPECT_EQ(jobs(overrides).back().file, "val/val-000001.tar");
}

// No shard is larger than asked, whatever the beams meet, unless it holds one sample alone.
TEST_F(ShardJobs, AreNeverLargerThanAsked) {
  const std::vector<std::string> large{
      "sensors.0.columns=2048",       "output.shard_mb=1",
      "output.formats=[csv]",         "output.columns=[intensity, label, instance, ring, column, time]",
      "trajectories.0.every_s=0.001", "trajectories.0.frames=12"};
  const Manifest m = sound(large);
  EXPECT_GT(m.shards.size(), 2u);
  for (const ShardRecord& s : m.shards) EXPECT_TRUE(s.bytes <= 1'000'000 || s.samples == 1) << s.bytes;
}

}  // namespace
}  // namespace scanmill
