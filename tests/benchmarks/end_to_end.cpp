// The whole way to a dataset, against a loop written by hand over the same libraries (hand_written.h): the same scenes,
// poses, beams and columns, on all cores, both into shared memory, so that the disk is not measured. `of_hand_written`
// is the ratio of the rates in one run. Ours writes shards with hashes, descriptions and a manifest besides. Loading
// the scene and building its hierarchy counts for neither.
//
// Two scenes: the procedural street, and a single mesh of 1.2 million triangles that is read from a PLY.

#include <benchmark/benchmark.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "pipeline/run/generate.h"
#include "pipeline/scenes/shot_source.h"
#include "tests/benchmarks/hand_written.h"
#include "tests/benchmarks/timing.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

constexpr std::uint32_t kFrames = 100;

std::filesystem::path outFolder() {
  return std::filesystem::exists("/dev/shm") ? "/dev/shm/scanmill-benchmark"
                                             : std::filesystem::temp_directory_path() / "scanmill-benchmark";
}

// A bowl of ground with low waves, 120 m wide.
void writeBowl(const std::filesystem::path& file) {
  constexpr std::uint32_t kSide = 775;
  std::ofstream out(file, std::ios::binary);
  out << "ply\nformat binary_little_endian 1.0\nelement vertex " << kSide * kSide
      << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << 2 * (kSide - 1) * (kSide - 1)
      << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
    const auto x = static_cast<float>(i % kSide) * 120.0f / kSide - 60;
    const auto y = static_cast<float>(i / kSide) * 120.0f / kSide - 60;
    const float z = 0.05f * std::sin(0.3f * x) * std::cos(0.2f * y) + std::max(0.0f, 0.5f * (std::hypot(x, y) - 15));
    for (const float value : {x, y, z}) out.write(reinterpret_cast<const char*>(&value), sizeof value);
  }
  for (std::uint32_t i = 0; i < kSide * (kSide - 1); ++i) {
    if (i % kSide == kSide - 1) continue;
    for (const Triangle& t : {Triangle{i, i + 1, i + kSide + 1}, Triangle{i, i + kSide + 1, i + kSide}}) {
      out.put(3);
      out.write(reinterpret_cast<const char*>(t.data()), sizeof t);
    }
  }
}

// Writes the files of a run; returns its pipeline.
std::filesystem::path writePipeline(const TemporaryFolder& folder, bool bowl, const std::string& format) {
  const std::string root = SCANMILL_SOURCE_DIR;
  std::string scene = root + "/scenes/street.yaml";
  if (bowl) {
    writeBowl(folder.path() / "bowl.ply");
    scene = folder
                .write("bowl.yaml", "ontology: semantic_kitti\nmaterials: " + root +
                                        "/labels/materials.yaml\nobjects: [{name: ground, file: bowl.ply, class: "
                                        "terrain, material: soil}]\n")
                .string();
  }
  return folder.write(
      "pipeline.yaml",
      "scenes: [{scene: " + scene + "}]\n" +
          "trajectories: [{waypoints: [[-10, -1.75, 0], [10, -1.75, 0]], speed: 1, every_m: 0.2, "
          "frames: " +
          std::to_string(kFrames) + "}]\n" + "sensors: [{preset: " + root +
          "/pipelines/sensors/paper_64.yaml, mount: {position: [0, 0, 1.9]}}]\n" +
          "method: ray_tracing\neffects: [{intensity: {output: u8}}, {range_noise: {sigma_m: 0.02}}]\n" +
          "output: {columns: [intensity, label, instance, ring, column], formats: [" + format + "]}\n");
}

void endToEnd(benchmark::State& state, bool bowl, const std::string& ourFormat, HandWrittenFormat theirFormat) {
  const TemporaryFolder folder;
  const Plan plan = makePlan(readPipeline(writePipeline(folder, bowl, ourFormat), {}));
  ShotSource source(plan);
  const Scene scene = source.load(0);
  std::vector<Pose> poses;
  for (std::uint32_t frame = 0; frame < kFrames; ++frame) {
    poses.push_back(source.frame(0, frame).shots.front().worldFromSensor.front());
  }
  const HandWritten handWritten(scene, *plan.sensors.front().beams, poses[kFrames / 2].translation);
  GenerateOptions options;
  options.folder = outFolder();
  options.overwrite = true;
  options.quiet = true;
  std::vector<double> ours;
  std::vector<double> theirs;
  double points = 0;
  double theirPoints = 0;
  for (auto _ : state) {
    const GenerateSummary summary = generate(plan, options);
    std::filesystem::remove_all(outFolder());
    ours.push_back(summary.seconds - summary.stages.at("setup"));
    points = static_cast<double>(summary.points);
    theirs.push_back(
        secondsOf([&] { theirPoints = static_cast<double>(handWritten.writeScans(poses, theirFormat, outFolder())); }));
    std::filesystem::remove_all(outFolder());
    state.SetIterationTime(ours.back());
  }
  const double beams = static_cast<double>(plan.pipeline.beamsPerFrame()) * kFrames;
  state.counters["beams/s"] = beams / median(ours);
  state.counters["hand_written_beams/s"] = beams / median(theirs);
  state.counters["of_hand_written"] = median(theirs) / median(ours);
  state.counters["points_of_theirs"] = points / theirPoints;
}

#define SCANMILL_END_TO_END(name, ourFormat, theirFormat)                   \
  BENCHMARK_CAPTURE(endToEnd, name##_street, false, ourFormat, theirFormat) \
      ->UseManualTime()                                                     \
      ->Iterations(5)                                                       \
      ->Unit(benchmark::kMillisecond);                                      \
  BENCHMARK_CAPTURE(endToEnd, name##_bowl, true, ourFormat, theirFormat)    \
      ->UseManualTime()                                                     \
      ->Iterations(5)                                                       \
      ->Unit(benchmark::kMillisecond)

SCANMILL_END_TO_END(pcd, "{pcd: {encoding: binary}}", HandWrittenFormat::Pcd);
SCANMILL_END_TO_END(compressed_pcd, "pcd", HandWrittenFormat::CompressedPcd);
SCANMILL_END_TO_END(draco, "{draco: {max_error_mm: 1}}", HandWrittenFormat::Draco);

}  // namespace
}  // namespace scanmill
