// What plan says of the disk, against what generate writes.

#include "pipeline/plan/dataset_size.h"

#include "scene/thing_boxes.h"
#include "tests/core/pipeline/small_world.h"

namespace scanmill {
namespace {

namespace fs = std::filesystem;

double bytesIn(const fs::path& folder) {
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) bytes += entry.file_size();
  }
  return static_cast<double>(bytes);
}

class DatasetSize : public Yard {
 protected:
  // What plan says at most, over what is written.
  double excess(const std::vector<std::string>& overrides, const std::string& name) const {
    const Plan plan(readPipeline(pipeline_, overrides));
    const Scene scene = plan.loadScene(plan.pipeline().sequences[0]);
    const double most = mostDatasetBytes(plan, scene.ontology, ThingBoxes(scene).things().size());
    const GenerateSummary made = run(overrides, name);
    EXPECT_EQ(made.manifest.columns, scanColumnNames(plan.columns()));
    return most / bytesIn(out(name));
  }
};

TEST_F(DatasetSize, IsAtMostWhatThePlanSaysAndNotFarBelow) {
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
    const double small = excess(overrides, fmt::format("small{}", number));
    EXPECT_GE(small, 1);
    EXPECT_LE(small, 3);
    overrides.insert(overrides.end(), noisy.begin(), noisy.end());
    const double large = excess(overrides, fmt::format("large{}", number++));
    EXPECT_GE(large, 1);
    EXPECT_LE(large, 3);
  }
}

TEST_F(DatasetSize, HoldsForLayoutsColumnsAndShards) {
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
