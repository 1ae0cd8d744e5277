// What shards leave room for, against what generate writes.

#include "pipeline/plan/sample_size.h"

#include "dataset/shard.h"
#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

class SampleSize : public Yard {
 protected:
  // What samples take at most, over what those that are made take on the mean.
  double excess(const std::vector<std::string>& overrides, const std::string& name) const {
    const Plan plan(readPipeline(pipeline_, overrides));
    const GenerateSummary made = run(overrides, name);
    EXPECT_EQ(made.manifest.columns, scanColumnNames(plan.columns()));
    double bytes = 0;
    for (const ShardRecord& shard : made.manifest.shards)
      bytes += static_cast<double>(shard.bytes) - ShardFile::kEndBytes;
    return mostSampleBytes(plan) * static_cast<double>(made.samples) / bytes;
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
