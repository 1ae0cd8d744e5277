// The bound of a sample's bytes against samples that generate writes.

#include "dataset/shard.h"
#include "pipeline/plan/shard_jobs.h"
#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

class SampleSize : public Yard {
 protected:
  // The bound over the bytes of the largest sample that is made.
  double excess(const std::vector<std::string>& overrides, const std::string& name) const {
    const Plan plan = makePlan(readPipeline(pipeline_, overrides));
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
  const std::vector<std::string> formats{"pcd",
                                         "pcd: {encoding: binary}",
                                         "pcd: {encoding: ascii}",
                                         "csv",
                                         "draco",
                                         "draco: {max_error_mm: 20, time: true, intensity_bits: 8}",
                                         "pcd, draco, csv"};
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
  // Where what was drawn is most of a sample, which has no beams to speak of.
  EXPECT_GE(excess({"output.columns=[]", "sensors.0.columns=4", "sensors.0.elevation_deg=[-10]",
                    "sensors.0.mount.position.2={uniform: [1, 2]}", "sensors.0.mount.roll_deg={normal: [0, 1]}",
                    "effects=[{choice: [{range_noise: {sigma_m: {uniform: [0.1, 0.2], per: frame}}}, {angular_jitter: "
                    "{azimuth_sigma_deg: {uniform: [0.1, 0.2]}, elevation_sigma_deg: {uniform: [0.1, 0.2]}}}]}]"},
                   "draws"),
            1);
  // Where the list of objects is most of a sample: two sensors of few beams.
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
}

}  // namespace
}  // namespace scanmill
