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
    return shardJobs(Plan(readPipeline(pipeline_, overrides)));
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
