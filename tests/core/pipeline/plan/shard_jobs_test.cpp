#include "pipeline/plan/shard_jobs.h"

#include <set>

#include "dataset/shard_writer.h"
#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

class ShardJobs : public Yard {
 protected:
  std::vector<ShardJob> jobs(const std::vector<std::string>& overrides) const { return shardJobs(planOf(overrides)); }
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

class SampleSize : public Yard {
 protected:
  // The bound over the bytes of the largest sample that is made.
  double excess(const std::vector<std::string>& overrides, const std::string& name) const {
    const Plan plan = planOf(overrides);
    EXPECT_EQ(run(overrides, name).manifest.columns, scanColumnNames(plan.columns()));
    std::map<std::string, std::uint64_t> bytes;  // by sample
    for (const auto& [member, contents] : members(name)) {
      bytes[member.substr(0, member.find('.'))] += ShardFile::memberBytes(member.size(), contents.size());
    }
    std::uint64_t largest = 0;
    for (const auto& [sample, size] : bytes) largest = std::max(largest, size);
    return mostSampleBytes(plan) / static_cast<double>(largest);
  }
};

TEST_F(SampleSize, BoundsSamplesAndIsNotFarAboveLargeOnes) {
  const std::vector<std::string> formats{"pcd", "pcd: {encoding: ascii}", "csv",
                                         "draco: {max_error_mm: 20, time: true}", "pcd, draco, csv"};
  const std::vector<std::string> noisy{
      "sensors.0.columns=1024", "motion=per_column",
      "effects=[intensity, range_noise: {sigma_m: 0.05}, angular_jitter: {sigma_deg: 0.1}]"};
  int number = 0;
  for (const std::string& format : formats) {
    SCOPED_TRACE(format);
    std::vector<std::string> overrides{"output.formats=[" + format + "]"};
    EXPECT_GE(excess(overrides, fmt::format("small{}", number)), 1);
    overrides.insert(overrides.end(), noisy.begin(), noisy.end());
    const double large = excess(overrides, fmt::format("large{}", number++));
    EXPECT_GE(large, 1);
    EXPECT_LE(large, 3.5);
  }
}

TEST_F(SampleSize, HoldsForLayoutsColumnsAndShards) {
  EXPECT_GE(
      excess({"output.layout=organised", "sensors.0.elevation_deg.top=60", "output.formats=[pcd, csv]"}, "misses"), 1);
  EXPECT_GE(excess({"output.columns=[]", "output.formats=[pcd: {encoding: binary}]"}, "positions"), 1);
  EXPECT_GE(excess({"output.voxels={size: 1, from: [-20, -20, -2], to: [20, 20, 2]}"}, "voxels"), 1);
  // Random values are most of this sample, which has few beams.
  EXPECT_GE(excess({"output.columns=[]", "sensors.0.columns=4", "sensors.0.elevation_deg=[-10]",
                    "sensors.0.mount.position.2={uniform: [1, 2]}", "sensors.0.mount.roll_deg={normal: [0, 1]}",
                    "effects=[{choice: [{range_noise: {sigma_m: {uniform: [0.1, 0.2], per: frame}}}, {angular_jitter: "
                    "{azimuth_sigma_deg: {uniform: [0.1, 0.2]}, elevation_sigma_deg: {uniform: [0.1, 0.2]}}}]}]"},
                   "draws"),
            1);
  // The list of objects is most of this sample: two sensors of few beams.
  EXPECT_GE(excess({"output.objects=true", "output.columns=[]", "output.formats=[{draco: {max_error_mm: 50}}]",
                    "sensors=[" + kTop +
                        ", {name: a-sensor-with-a-long-name, columns: 4, rate_hz: 10, elevation_deg: "
                        "[-10], range_m: [0.5, 100]}]",
                    "sensors.0.columns=4"},
                   "objects"),
            1);
  EXPECT_GE(
      excess({"output.shard_mb=1", "trajectories.0.every_s=0.001", "trajectories.0.frames=60", "sensors.0.columns=1024",
              "scenes.0.seeds=[1, 2, 3]", "output.formats=[csv]", "splits={by: seed, train: [1], val: [2], test: [3]}"},
             "shards"),
      1);
  EXPECT_GE(excess({"sensors=[" + kTop + ", {name: " + std::string(90, 'r') +
                    ", columns: 4, rate_hz: 10, elevation_deg: [0], range_m: [1, 9]}]"},
                   "long"),
            1);
  EXPECT_GE(excess({"sensors.0.divergence_mrad=12", "sensors.0.pulse_ns=1", "output.formats=[csv]",
                    "effects=[intensity, footprint: {rays: 19}, detection: {returns: all}]"},
                   "returns"),
            1);
}

}  // namespace
}  // namespace scanmill
