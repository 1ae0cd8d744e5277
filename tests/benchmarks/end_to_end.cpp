// The whole way to shards, against what the libraries' own calls cost on the same data: bare Embree over the same
// triangles and beams, and the bare encoder over the same scans, both on all cores, one after the other. `of_bare` is
// the ratio in one run: above 1, the overlap and our encoder more than pay for effects, columns, hashing and writing.
// The procedural street, 1.3 million triangles, 64 x 2048 beams, labels, instances and intensity. Shards go to
// shared memory, so that the disk is not measured.

#include <benchmark/benchmark.h>
#include <pcl/PCLPointCloud2.h>
#include <pcl/io/pcd_io.h>

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "dataset/reader.h"
#include "pipeline/run/generate.h"
#include "tests/benchmarks/bare_draco.h"
#include "tests/benchmarks/bare_embree.h"
#include "tests/benchmarks/timing.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

constexpr std::uint32_t kFrames = 64;

std::string pipelineText(const std::string& format) {
  const std::string root = SCANMILL_SOURCE_DIR;
  return "scenes: [{scene: " + root + "/scenes/street.yaml}]\n" +
         "trajectories: [{waypoints: [[-50, -1.75, 0], [50, -1.75, 0]], speed: 10, every_m: 1.5, frames: " +
         std::to_string(kFrames) + "}]\n" + "sensors: [{preset: " + root +
         "/pipelines/sensors/paper_64.yaml, mount: {position: [0, 0, 1.9]}}]\n" +
         "method: ray_tracing\neffects: [{intensity: {output: u8}}]\n" +
         "output: {columns: [intensity, label, instance, ring, column], formats: [" + format + "]}\n";
}

std::filesystem::path shardFolder() {
  return std::filesystem::exists("/dev/shm") ? "/dev/shm/scanmill-benchmark"
                                             : std::filesystem::temp_directory_path() / "scanmill-benchmark";
}

// Median seconds for one frame: bare trace.
double bareTraceSeconds(const Plan& plan, const Scene& scene) {
  const Shot shot = plan.shots(0, kFrames / 2).front();
  BareEmbree bare(scene, *shot.beams, shot.worldFromSensor.front().translation);
  std::vector<double> seconds[2];
  for (int i = 0; i < 15; ++i) {
    for (const std::size_t order : {0, 1}) seconds[order].push_back(secondsOf([&] { bare.trace(order, 16); }));
  }
  return std::min(median(seconds[0]), median(seconds[1]));
}

std::vector<Scan> readScans(const std::filesystem::path& folder) {
  std::vector<Scan> scans;
  const Manifest manifest = readManifest(folder);
  readTar(folder / manifest.shards.front().file, [&](const std::string& name, std::string_view bytes) {
    if (!name.ends_with(".json")) scans.push_back(decodeMember(name, bytes));
  });
  return scans;
}

// Seconds for one scan when all cores encode at once. What the encoder reads is made before the clock starts.
double bareEncodeSeconds(const std::vector<Scan>& scans, const auto& prepare, const auto& encode) {
  std::vector<decltype(prepare(scans.front()))> inputs;
  for (const Scan& scan : scans) inputs.push_back(prepare(scan));
  std::vector<double> seconds;
  for (int i = 0; i < 5; ++i) {
    seconds.push_back(secondsOf([&] {
      parallelFor(inputs.size(), 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t s = first; s < last; ++s) encode(inputs[s], s);
      });
    }));
  }
  return median(seconds) / static_cast<double>(scans.size());
}

void endToEnd(benchmark::State& state, const std::string& format, const auto& prepare, const auto& encode) {
  TemporaryFolder folder;
  const Plan plan(readPipeline(folder.write("pipeline.yaml", pipelineText(format)), {}));
  const std::filesystem::path out = shardFolder();
  const Scene scene = plan.loadScene(plan.pipeline().sequences.front());
  GenerateOptions options;
  options.folder = out;
  options.overwrite = true;
  options.quiet = true;
  std::vector<double> oursSeconds;
  std::vector<double> bareSeconds;
  double points = 0;
  double bytes = 0;
  for (auto _ : state) {
    const GenerateSummary summary = generate(plan, options);
    const double busy = summary.seconds - summary.stages.at("setup");
    state.SetIterationTime(busy);
    oursSeconds.push_back(busy / kFrames);
    points = static_cast<double>(summary.points) / kFrames;
    bytes = static_cast<double>(summary.bytes) / kFrames;
    bareSeconds.push_back(bareTraceSeconds(plan, scene) + bareEncodeSeconds(readScans(out), prepare, encode));
  }
  std::filesystem::remove_all(out);
  state.counters["points/s"] = points / median(oursSeconds);
  state.counters["bare_points/s"] = points / median(bareSeconds);
  state.counters["of_bare"] = median(bareSeconds) / median(oursSeconds);
  state.counters["B/point"] = bytes / points;
}

pcl::PCLPointCloud2 asPclCloud(const Scan& scan) {
  const Value options = parseYaml("encoding: binary", "benchmark");
  Fields fields(options, "pcd");
  TemporaryFolder folder;
  const auto file = folder.write("scan.pcd", requireFormat("pcd", {}).make(fields)->encode(scan));
  pcl::PCLPointCloud2 cloud;
  pcl::PCDReader().read(file.string(), cloud);
  return cloud;
}

std::string scratchFile(std::size_t index) {
  return (shardFolder().string() + "-bare-") + std::to_string(index) + ".pcd";
}

void toPcd(benchmark::State& state) {
  endToEnd(state, "{pcd: {encoding: binary}}", asPclCloud, [](const pcl::PCLPointCloud2& cloud, std::size_t i) {
    pcl::PCDWriter().writeBinary(scratchFile(i), cloud);
    std::filesystem::remove(scratchFile(i));
  });
}
BENCHMARK(toPcd)->UseManualTime()->Iterations(5)->Unit(benchmark::kMillisecond);

void toCompressedPcd(benchmark::State& state) {
  endToEnd(state, "pcd", asPclCloud, [](const pcl::PCLPointCloud2& cloud, std::size_t) {
    std::ostringstream out;
    pcl::PCDWriter().writeBinaryCompressed(out, cloud);
    benchmark::DoNotOptimize(out.tellp());
  });
}
BENCHMARK(toCompressedPcd)->UseManualTime()->Iterations(5)->Unit(benchmark::kMillisecond);

void toDraco(benchmark::State& state) {
  endToEnd(
      state, "{draco: {max_error_mm: 1}}", [](const Scan& scan) { return scan; },
      [](const Scan& scan, std::size_t) { benchmark::DoNotOptimize(bareDracoBytes(scan, {}).size()); });
}
BENCHMARK(toDraco)->UseManualTime()->Iterations(5)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace scanmill
