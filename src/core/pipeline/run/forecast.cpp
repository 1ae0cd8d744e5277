#include "pipeline/run/forecast.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <ctime>
#include <filesystem>
#include <optional>
#include <set>
#include <thread>

#include "base/hash.h"
#include "base/parallel.h"
#include "base/random.h"
#include "base/stage_clock.h"
#include "config/distribution.h"
#include "config/resources.h"
#include "config/value.h"
#include "dataset/shard_writer.h"
#include "pipeline/run/sample_maker.h"
#include "pipeline/scenes/shot_source.h"

namespace scanmill {

namespace {

constexpr double kStartSeconds = 0.1;  // time for reading the pipeline and finishing the dataset (s)
constexpr double kLowMount = 0.5;      // m above the vehicle's origin; lower sensors count as mounted on the ground
// Beams and rays of a frame of the small town; larger frames are thinned to these.
constexpr double kMostBeams = 5e5;
constexpr double kMostRays = 3e6;

// Factors by which the costs of the small town are multiplied for a kind of scene, and spreads: the factors by which
// measured values were above or below forecasts. All were fitted to the pipelines that come with the program (2 cores
// of an AMD EPYC; tests/benchmarks/forecast.cpp). Those of set-up are small, since the small town is the first scene of
// the process.
struct SceneFactors {
  double setup;
  double frame;
  double bytes;
  double timeSpread;
  double byteSpread;
};

double numberOr(const Value& map, std::string_view key, double otherwise) {
  const Value* const value = map.find(key);
  if (value == nullptr || value->kind != Value::Kind::Scalar) return otherwise;
  double number = otherwise;
  std::from_chars(value->text.data(), value->text.data() + value->text.size(), number);
  return number;
}

// Returns the keys of the town among a scene's objects; null if there is none.
const Value* townIn(const Value& objects) {
  for (const Value& object : objects.items) {
    if (const Value* const town = object.find("town")) return town;
  }
  return nullptr;
}

SceneFactors factorsOf(const std::filesystem::path& file) {
  const Value root = readYaml(file);
  const Value* const town = townIn(root.valueOf("objects"));
  // The spreads for asset files are wide, since the contents of the files are unknown before they are loaded.
  if (town == nullptr) return {0.3, 0.42, 0.8, 2.5, 2};
  constexpr double kUsualLength = 300;  // length of a town whose file states none (m)
  const double setup = 0.4 + 0.28 * numberOr(*town, "length", kUsualLength) / 100;
  return {setup, 1, 0.97, 1.5, 1.2};
}

// Adds changes that leave `share` of the columns of each sensor that states a number of columns.
void takeFewerColumns(const Pipeline& pipeline, double share, std::vector<std::string>& changes) {
  for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
    const Value& sensor = pipeline.sensors[s].description;
    if (sensor.find("columns") == nullptr || sensor.find("raster") != nullptr) continue;
    const auto columns = static_cast<std::uint64_t>(static_cast<double>(pipeline.sensors[s].size.columns) * share);
    changes.push_back(
        fmt::format("sensors.{}.columns={}", s, std::max<std::uint64_t>({columns, 1, pipeline.motion.steps})));
  }
}

// Returns the pipeline with its scenes replaced by the small town of scenes/hamlet.yaml, and with fewer columns if a
// frame has more than kMostBeams or kMostRays. `townsClasses`: true: with the classes of that scene, and without the
// ego vehicle, which may have others; false: with the pipeline's classes.
Pipeline inSmallTown(const Pipeline& pipeline, const Reread& reread, bool townsClasses) {
  Value town;
  town.kind = Value::Kind::Scalar;
  town.text = (resourceFolder() / "scenes" / "hamlet.yaml").string();
  // If the method cannot trace moving objects, the pipeline's scenes have none, so the small town must have none
  // either.
  const MethodEntry* const method = pipeline.method.entry;
  const bool moving = (method == nullptr || method->can.moving) &&
                      std::ranges::any_of(pipeline.sequences, [](const Sequence& sequence) { return sequence.moving; });
  // If all mounts are on the ground, the poses of the pipeline's drives must contain the sensors' height.
  const bool low = std::ranges::all_of(
      pipeline.sensors, [](const MountedSensor& sensor) { return sensor.vehicleFromSensor.translation.z < kLowMount; });
  std::vector<std::string> changes{
      fmt::format("scenes=[{{scene: {}, seeds: [1], moving: {}}}]", flowText(town), moving),
      fmt::format("trajectories=[{{name: forecast, along: lane, speed: 8, every_m: 10, frames: {}{}}}]", threadCount(),
                  low ? ", ground: {height: 1.8}" : ""),
      "splits=null"};
  if (townsClasses) changes.insert(changes.end(), {"labels=null", "vehicle=null"});
  const double share = std::min(kMostBeams / static_cast<double>(pipeline.beamsPerFrame()),
                                kMostRays / static_cast<double>(pipeline.raysPerFrame()));
  if (share < 1) takeFewerColumns(pipeline, share, changes);
  return reread(changes);
}

// Makes samples of the plan's first sequence, one for each thread, and stores in `costs` the measured times and sizes
// of the scene and of a frame. The samples are made twice, and the second time is measured, since the first frames of a
// program take longer: they map memory, and build what hierarchies lack.
void measure(const Plan& plan, SampleCosts& costs) {
  const std::size_t samples = std::min<std::size_t>(plan.framesInFlight(), plan.pipeline.sequences[0].frames);
  ShotSource source(plan);
  SampleMaker maker(source, {}, false, [](const Sequence&) {});
  const WallTimer setup;
  const std::clock_t before = std::clock();  // processor time, summed over all threads
  maker.scenes().enter(0);
  costs.slowestSceneSeconds = setup.seconds();
  costs.sceneSeconds = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
  std::vector<double> bytes(samples);
  const auto makeAll = [&] {
    parallelFor(samples, 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const MadeSample made = maker.make({0, static_cast<std::uint32_t>(i), i});
        Sha256 hash;  // a shard's hash is part of the cost of writing
        for (const Member& member : made.sample.members) hash.add(member.bytes);
        hash.hex();
        bytes[i] = static_cast<double>(bytesInShard(made.sample));
      }
    });
  };
  makeAll();
  const WallTimer timer;
  makeAll();
  costs.frameSeconds = timer.seconds();  // of one frame for each thread
  for (const double b : bytes) costs.frameBytes += b / static_cast<double>(samples);
}

// Measures the costs of the small town, and scales those of a frame to all of the pipeline's beams.
void measureInSmallTown(const Pipeline& pipeline, const Reread& reread, bool townsClasses, SampleCosts& costs) {
  const Plan small = makePlan(inSmallTown(pipeline, reread, townsClasses));
  measure(small, costs);
  const double more =
      static_cast<double>(pipeline.beamsPerFrame()) / static_cast<double>(small.pipeline.beamsPerFrame());
  costs.frameSeconds *= more;
  costs.frameBytes *= more;
}

// Scales the costs of the small town to the pipeline's scenes, by the factors of these scenes.
void scale(const Pipeline& pipeline, SampleCosts& costs) {
  SceneFactors mean{0, 0, 0, 1, 1};
  std::optional<std::pair<std::filesystem::path, SceneFactors>> known;
  double slowest = 0;
  for (std::size_t i = 0; i < pipeline.sequences.size(); ++i) {
    const Sequence& sequence = pipeline.sequences[i];
    if (!known || known->first != sequence.sceneFile) known = {sequence.sceneFile, factorsOf(sequence.sceneFile)};
    const SceneFactors& own = known->second;
    const double share = static_cast<double>(sequence.frames) / static_cast<double>(pipeline.frames());
    mean.frame += share * own.frame;
    mean.bytes += share * own.bytes;
    mean.timeSpread = std::max(mean.timeSpread, own.timeSpread);
    mean.byteSpread = std::max(mean.byteSpread, own.byteSpread);
    if (i > 0 && sequence.sameScene(pipeline.sequences[i - 1])) continue;
    mean.setup += own.setup;
    slowest = std::max(slowest, own.setup);
  }
  costs.sceneSeconds *= mean.setup / static_cast<double>(scenesOf(pipeline));
  costs.slowestSceneSeconds *= slowest;
  costs.frameSeconds *= mean.frame;
  costs.frameBytes *= mean.bytes;
  costs.timeSpread = mean.timeSpread;
  costs.byteSpread = mean.byteSpread;
  // The time of methods other than ray tracing depends more on a scene's size and on where its triangles are.
  constexpr double kOtherMethods = 2.5;
  if (pipeline.methodName() != "ray_tracing") costs.timeSpread = std::max(costs.timeSpread, kOtherMethods);
}

}  // namespace

SampleCosts measureSampleCosts(const Plan& plan, const Reread& reread) {
  SampleCosts costs;
  costs.threads = static_cast<int>(plan.framesInFlight());
  costs.cores = std::min(costs.threads, std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
  if (plan.pipeline.recording != nullptr) {
    measure(plan, costs);
    costs.timeSpread = 1.5;
    costs.byteSpread = 1.2;
    return costs;
  }
  try {
    measureInSmallTown(plan.pipeline, reread, false, costs);
  } catch (const InputError&) {
    // The town may not fit the pipeline's classes, which hardly change the costs.
    measureInSmallTown(plan.pipeline, reread, true, costs);
  }
  scale(plan.pipeline, costs);
  return costs;
}

bool followsFromSeeds(const Pipeline& pipeline) {
  std::set<std::filesystem::path> files;
  for (const Sequence& sequence : pipeline.sequences) files.insert(sequence.sceneFile);
  return std::ranges::any_of(files, [](const std::filesystem::path& file) {
    const Value root = readYaml(file);
    std::vector<DrawnValue> draws;
    const Value& objects = root.valueOf("objects");
    withDraws(objects, "objects", {}, draws);
    return !draws.empty() || townIn(objects) != nullptr;
  });
}

std::uint64_t scenesOf(const Pipeline& pipeline) {
  std::uint64_t scenes = 0;
  for (std::size_t i = 0; i < pipeline.sequences.size(); ++i) {
    scenes += i == 0 || !pipeline.sequences[i].sameScene(pipeline.sequences[i - 1]) ? 1 : 0;
  }
  return scenes;
}

Forecast forecast(const SampleCosts& costs, std::uint64_t frames, std::uint64_t scenes) {
  const double threads = costs.threads;
  // The frames of a scene cannot start before the scene is set up. If there are several scenes, each thread sets up
  // one.
  const double setup =
      std::max(static_cast<double>(scenes) * costs.sceneSeconds / costs.cores, costs.slowestSceneSeconds);
  const double rounds = std::max(static_cast<double>(frames) / threads, 1.0);
  const double seconds = kStartSeconds + setup + rounds * costs.frameSeconds;
  const double bytes = static_cast<double>(frames) * costs.frameBytes;
  return {frames,
          costs.threads,
          {seconds / costs.timeSpread, seconds, seconds * costs.timeSpread},
          {bytes / costs.byteSpread, bytes, bytes * costs.byteSpread}};
}

}  // namespace scanmill
