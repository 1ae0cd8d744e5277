// The depth camera, stage by stage, on the procedural street (1.3 million placed triangles): 64 x 2048 beams
// from three images of 2048 x 2048 with depth, normals, ids and reflectance, and what the alternatives cost in the same
// run. `of_*` are ratios of times in one run.

#include "methods/depth_camera/depth_camera.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

#include "methods/depth_camera/revolution.h"
#include "passes/exr/hits_exr.h"
#include "passes/exr/pass_exr.h"
#include "passes/renderer.h"
#include "pipeline/run/generate.h"
#include "pipeline/run/recorder.h"
#include "tests/benchmarks/against_ray_tracing.h"
#include "tests/benchmarks/timing.h"
#include "tests/support/embree_passes.h"
#include "tests/support/street.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {
namespace {

// Stages are of the last scan's.
void scan(benchmark::State& state, const std::string& layout) {
  scanAgainstRayTracing(state, "depth_camera", "{layout: " + layout + "}");
}
SCANS(three_120, "three_120");
SCANS(automatic, "auto");

struct ThreeImages {
  Shot shot = streetShot(presetBeams("paper_64"), -20);
  std::vector<Camera> cameras;
  DrawLimits limits;

  ThreeImages() {
    cameras = layOutCameras(shot.beams->direction, {CameraLayout::Three120, 2048});
    for (Camera& camera : cameras) camera.worldFromCamera = shot.worldFromSensor.front() * camera.worldFromCamera;
    limits = {0.01, shot.beams->maxRange};
  }
};

constexpr PassChoice kDepthNormalIds{Channels(Channel::Range) | Channel::Normal | Channel::Instance |
                                     Channel::Semantic | Channel::Material};

// The same three images, all pixels with depth, normals and ids: drawn, and traced by Embree.
void images(benchmark::State& state) {
  const ThreeImages three;
  const auto vtk = makeVtkRenderer(street());
  EmbreePasses embree(street());
  const auto drawn = [&] {
    const auto source = vtk->draw(three.cameras, three.limits, kDepthNormalIds);
    benchmark::DoNotOptimize(readAll(*source, kDepthNormalIds).size());
  };
  const auto traced = [&] { embree.draw(three.cameras, three.limits, kDepthNormalIds); };
  drawn();
  traced();
  std::vector<double> drawnSeconds;
  std::vector<double> tracedSeconds;
  for (auto _ : state) {
    drawnSeconds.push_back(secondsOf(drawn));
    state.SetIterationTime(drawnSeconds.back());
    tracedSeconds.push_back(secondsOf(traced));
  }
  state.counters["pixels/s"] = 3.0 * 2048 * 2048 / median(drawnSeconds);
  state.counters["embree_pixels/s"] = 3.0 * 2048 * 2048 / median(tracedSeconds);
  state.counters["of_embree"] = median(drawnSeconds) / median(tracedSeconds);
}
BENCHMARK(images)->UseManualTime()->Iterations(5)->Unit(benchmark::kMillisecond);

// Sampling alone, from images in memory.
void sampling(benchmark::State& state, Sampling how) {
  const ThreeImages three;
  EmbreePasses embree(street());
  const auto source = embree.draw(three.cameras, three.limits, {Channels::all(), false});
  const RigBeams beams = rigBeams(three.shot, 0, three.shot.beams->columns, three.shot.worldFromSensor.front());
  SampleOptions options;
  options.sampling = how;
  options.farthest = three.limits.farthest;
  Hits hits;
  for (auto _ : state) {
    hits.reset(three.shot.beams->rings, three.shot.beams->columns, kTracedChannels);
    samplePixels(*source, three.shot.worldFromSensor.front(), beams, options, hits);
  }
  state.counters["beams/s"] =
      benchmark::Counter(static_cast<double>(hits.size()), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK_CAPTURE(sampling, plane, Sampling::Plane)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(sampling, nearest, Sampling::Nearest)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(sampling, bilinear, Sampling::Bilinear)->UseRealTime()->Unit(benchmark::kMillisecond);

// One image of 2048 x 2048 to an EXR file, and back.
void exr(benchmark::State& state) {
  const ThreeImages three;
  EmbreePasses embree(street());
  const PassImage image = embree.image(three.cameras.front(), three.limits, kDepthNormalIds);
  const TemporaryFolder folder;
  const auto file = folder.path() / "image.exr";
  std::vector<double> writing;
  std::vector<double> reading;
  for (auto _ : state) {
    writing.push_back(secondsOf([&] { writePasses(file, image); }));
    state.SetIterationTime(writing.back());
    reading.push_back(secondsOf([&] { readPasses(file, kDepthNormalIds); }));
  }
  state.counters["write_ms"] = 1e3 * median(writing);
  state.counters["read_ms"] = 1e3 * median(reading);
  state.counters["B/pixel"] = static_cast<double>(std::filesystem::file_size(file)) / (2048.0 * 2048);
}
BENCHMARK(exr)->UseManualTime()->Iterations(10)->Unit(benchmark::kMillisecond);

// Trace once, synthesise many: datasets from kept hits against tracing again.
void fromHits(benchmark::State& state, const std::string& method) {
  const TemporaryFolder folder;
  const std::string root = SCANMILL_SOURCE_DIR;
  const auto pipeline =
      folder.write("pipeline.yaml",
                   "scenes: [{scene: " + root + "/scenes/street.yaml}]\n" +
                       "trajectories: [{waypoints: [[-50, -1.75, 0], [50, -1.75, 0]], speed: 10, every_m: 3, "
                       "frames: 32}]\nsensors: [{preset: " +
                       root + "/pipelines/sensors/paper_64.yaml, mount: {position: [0, 0, 1.9]}}]\nmethod: " + method +
                       "\neffects: [{intensity: {output: u8}}, {range_noise: {sigma_m: 0.01}}]\n" +
                       "output: {columns: [intensity, label, instance, ring, column], formats: [draco]}\n");
  const auto hits = folder.path() / "hits";
  GenerateOptions options;
  options.folder = folder.path() / "out";
  options.keepHits = hits;
  options.quiet = true;
  options.overwrite = true;
  const double kept = generate(makePlan(readPipeline(pipeline, {}), recordedChannels()), options).seconds;
  options.keepHits.clear();
  const auto recording = std::make_shared<const Recording>(readRecording(hits, RecordingKind::Hits));
  const Plan direct = makePlan(readPipeline(pipeline, {}));
  const Plan again = makePlan(readPipeline(pipeline, {}, recording));
  std::vector<double> directSeconds;
  std::vector<double> againSeconds;
  for (auto _ : state) {
    directSeconds.push_back(generate(direct, options).seconds);
    againSeconds.push_back(generate(again, options).seconds);
    state.SetIterationTime(againSeconds.back());
  }
  std::uintmax_t bytes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(hits)) bytes += entry.file_size();
  state.counters["times_as_fast"] = median(directSeconds) / median(againSeconds);
  state.counters["keeping_of_direct"] = kept / median(directSeconds);
  state.counters["kept_MB/scan"] = static_cast<double>(bytes) / 32e6;
}
BENCHMARK_CAPTURE(fromHits, ray_tracing, "ray_tracing")->UseManualTime()->Iterations(3)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fromHits, depth_camera, "depth_camera")
    ->UseManualTime()
    ->Iterations(3)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace scanmill
