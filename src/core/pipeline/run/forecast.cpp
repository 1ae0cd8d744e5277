#include "pipeline/run/forecast.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <ctime>
#include <filesystem>
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

constexpr double kStartSeconds = 0.1;  // s, for reading the pipeline and finishing the dataset
constexpr double kLowMount = 0.5;      // m above the vehicle's origin; lower sensors count as mounted on the ground
// Largest numbers of beams and rays in a frame of the small town. The columns of larger frames are reduced, so that a
// forecast takes less than a second. If few columns are left, their rays are less coherent than the dataset's, and the
// forecast is too long, in a tripod's scan by a factor of 1.7.
constexpr double kMostBeams = 5e5;
constexpr double kMostRays = 3e5;

// Factors of a kind of scene. `setup`, `frame` and `bytes` multiply the costs of the small town; measured values were
// above or below forecasts by the spreads. All factors were fitted to the program's pipelines (2 cores of an AMD EPYC).
// Set-up factors are small, since the small town is the first scene of the process and its set-up therefore includes
// one-time work.
struct SceneFactors {
  double setup = 0;
  double frame = 0;
  double bytes = 0;
  double timeSpread = 1;
  double byteSpread = 1;
};
// Spreads for assets are wide, since the contents of their files are unknown before they are loaded.
constexpr SceneFactors kAssets{.setup = 0.3, .frame = 0.42, .bytes = 0.8, .timeSpread = 2.5, .byteSpread = 2};
constexpr SceneFactors kTowns{.setup = 0.4, .frame = 1, .bytes = 0.97, .timeSpread = 1.5, .byteSpread = 1.2};
constexpr double kFewColumnsSpread = 2;
constexpr double kSetupPerMetre = 0.0028;  // added to kTowns.setup for each metre of the town's length

// Returns the number of a key; `fallback` without the key, or if its value is no number.
double numberOr(const Value& map, std::string_view key, double fallback) {
  const Value* const value = map.find(key);
  if (value == nullptr || value->kind != Value::Kind::Scalar) return fallback;
  double number = fallback;
  std::from_chars(value->text.data(), value->text.data() + value->text.size(), number);
  return number;
}

SceneFactors factorsOf(const std::filesystem::path& sceneFile) {
  const Value root = readYaml(sceneFile);
  const Value* const town = root.valueOf("objects").findInItems("town");
  if (town == nullptr) return kAssets;
  constexpr double kUsualLength = 300;  // m, of a town whose file states none
  SceneFactors factors = kTowns;
  factors.setup += kSetupPerMetre * numberOr(*town, "length", kUsualLength);
  return factors;
}

// Adds arguments of --set that reduce the number of columns to the fraction `share`, for each sensor whose description
// states this number.
void addFewerColumns(const Pipeline& pipeline, double share, std::vector<std::string>& overrides) {
  for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
    const Value& sensor = pipeline.sensors[s].description;
    const std::string& key = pipeline.sensors[s].key;
    if (sensor.find("columns") == nullptr || sensor.find("raster") != nullptr) continue;
    const auto columns = static_cast<std::uint64_t>(static_cast<double>(pipeline.sensors[s].size.columns) * share);
    overrides.push_back(
        fmt::format("{}.columns={}", key, std::max<std::uint64_t>({columns, 1, pipeline.motion.steps})));
    if (pipeline.sensors[s].size.sectors > 1) overrides.push_back(key + ".sectors=1");
  }
}

// The ontology of the small town: its own, or the one that the pipeline names.
enum class TownClasses { Own, Pipeline };

// Returns the pipeline with its scenes replaced by the small town of scenes/hamlet.yaml, and with fewer columns if a
// frame has more than kMostBeams or kMostRays. With TownClasses::Own the ego vehicle is left out, since its classes may
// differ from the town's; mounts on its links become poses.
Pipeline smallTownPipeline(const Pipeline& pipeline, const Reread& reread, TownClasses classes) {
  const Value townFile = scalarValue((resourceFolder() / "scenes" / "hamlet.yaml").string());
  // If the method cannot trace moving objects, the pipeline's scenes have none, so the small town must have none
  // either.
  const MethodEntry* const method = pipeline.method.entry;
  const bool moving =
      (method == nullptr || method->can.moving) && std::ranges::any_of(pipeline.sequences, &Sequence::moving);
  // If all sensors are mounted near the vehicle's origin, the pipeline's trajectories probably run at the sensors'
  // height, so the trajectory in the small town must, too.
  const bool lowMounts = std::ranges::all_of(
      pipeline.sensors, [](const MountedSensor& sensor) { return sensor.vehicleFromSensor.translation.z < kLowMount; });
  std::vector<std::string> overrides{
      fmt::format("scenes=[{{scene: {}, seeds: [1], moving: {}}}]", flowText(townFile), moving),
      fmt::format("trajectories=[{{name: forecast, along: lane, speed: 8, every_m: 10, frames: {}{}}}]", threadCount(),
                  lowMounts ? ", ground: {height: 1.8}" : ""),
      "splits=null"};
  if (classes == TownClasses::Own) overrides.insert(overrides.end(), {"labels=null", "vehicle=null"});
  for (std::size_t s = 0; s < pipeline.sensors.size() && !pipeline.vehicle.empty(); ++s) {
    const auto& [q, p] = pipeline.sensors[s].vehicleFromSensor;
    overrides.push_back(fmt::format("{}.mount={{position: [{}, {}, {}], rotation: [{}, {}, {}, {}]}}",
                                    pipeline.sensors[s].key, p.x, p.y, p.z, q.w, q.x, q.y, q.z));
  }
  const double share = std::min(kMostBeams / static_cast<double>(pipeline.beamsPerFrame()),
                                kMostRays / static_cast<double>(pipeline.raysPerFrame()));
  const auto inSectors = [](const MountedSensor& sensor) { return sensor.size.sectors > 1; };
  if (share < 1 || std::ranges::any_of(pipeline.sensors, inSectors)) {
    addFewerColumns(pipeline, std::min(share, 1.0), overrides);  // one sector's columns as a turn
  }
  return reread(overrides);
}

// Makes samples of the plan's first sequence, one for each thread, and stores in `costs` the measured times and sizes
// of the scene and of a frame. Makes the samples twice and measures the second time, since the first frames of a
// program take longer: they allocate memory, and methods complete their ray-tracing hierarchies.
void measure(const Plan& plan, SampleCosts& costs) {
  const std::size_t sampleCount = std::min<std::size_t>(plan.framesInFlight(), plan.pipeline.sequences[0].frames);
  ShotSource source(plan);
  SampleMaker maker(source, {}, false, [](const Sequence&) {});
  const WallTimer setupTimer;
  const std::clock_t startTicks = std::clock();  // processor time, summed over all threads
  maker.scenes().enter(0);
  costs.slowestSceneSeconds = setupTimer.seconds();
  costs.sceneSeconds = static_cast<double>(std::clock() - startTicks) / CLOCKS_PER_SEC;
  std::vector<double> bytes(sampleCount);
  const auto makeAll = [&] {
    parallelForEach(sampleCount, 1, [&](std::size_t i) {
      const MadeSample sample = maker.make({0, static_cast<std::uint32_t>(i), i});
      Sha256 hash;  // a shard's hash is part of the cost of writing
      for (const Member& file : sample.sample.files) hash.add(file.bytes);
      hash.hex();
      bytes[i] = static_cast<double>(bytesInShard(sample.sample));
    });
  };
  makeAll();
  const WallTimer timer;
  makeAll();
  costs.frameSeconds = timer.seconds();  // of one frame for each thread
  for (const double sampleBytes : bytes) costs.frameBytes += sampleBytes / static_cast<double>(sampleCount);
}

// Measures the costs of the small town, and scales the costs of a frame to all of the pipeline's beams.
void measureInSmallTown(const Pipeline& pipeline, const Reread& reread, TownClasses classes, SampleCosts& costs) {
  const Plan small = makePlan(smallTownPipeline(pipeline, reread, classes));
  measure(small, costs);
  double beams = 0;  // of whole turns; the small town has no sectors
  for (const MountedSensor& sensor : pipeline.sensors)
    beams += static_cast<double>(sensor.beams() * sensor.size.sectors);
  const double beamRatio = beams / static_cast<double>(small.pipeline.beamsPerFrame());
  costs.frameSeconds *= beamRatio;
  costs.frameBytes *= beamRatio;
  constexpr double kFewColumns = 10;  // a ratio from which columns are few
  if (beamRatio > kFewColumns) costs.timeSpread = kFewColumnsSpread;
}

// Scales the costs of the small town to the pipeline's scenes, by the factors of these scenes.
void scale(const Pipeline& pipeline, SampleCosts& costs) {
  SceneFactors mean;  // weighted by frames; `setup` is the sum over scenes, and spreads are the largest
  double slowestSetup = 0;
  SceneFactors factors;  // of the sequence's scene file
  for (std::size_t i = 0; i < pipeline.sequences.size(); ++i) {
    const Sequence& sequence = pipeline.sequences[i];
    if (i == 0 || pipeline.sequences[i - 1].sceneFile != sequence.sceneFile) factors = factorsOf(sequence.sceneFile);
    const double share = static_cast<double>(sequence.frames) / static_cast<double>(pipeline.frames());
    mean.frame += share * factors.frame;
    mean.bytes += share * factors.bytes;
    mean.timeSpread = std::max(mean.timeSpread, factors.timeSpread);
    mean.byteSpread = std::max(mean.byteSpread, factors.byteSpread);
    if (i > 0 && sequence.sameScene(pipeline.sequences[i - 1])) continue;
    mean.setup += factors.setup;
    slowestSetup = std::max(slowestSetup, factors.setup);
  }
  costs.sceneSeconds *= mean.setup / static_cast<double>(scenesOf(pipeline));
  costs.slowestSceneSeconds *= slowestSetup;
  costs.frameSeconds *= mean.frame;
  costs.frameBytes *= mean.bytes;
  costs.timeSpread = std::max(costs.timeSpread, mean.timeSpread);
  costs.byteSpread = mean.byteSpread;
  // The time of methods other than ray tracing depends more on a scene's size and on where its triangles are.
  constexpr double kOtherMethodsSpread = 2.5;
  if (pipeline.methodName() != "ray_tracing") costs.timeSpread = std::max(costs.timeSpread, kOtherMethodsSpread);
}

}  // namespace

SampleCosts measureSampleCosts(const Plan& plan, const Reread& reread) {
  SampleCosts costs;
  costs.threads = static_cast<int>(plan.framesInFlight());
  costs.cores = std::min(costs.threads, std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
  if (plan.pipeline.recording != nullptr) {
    measure(plan, costs);
    costs.timeSpread = kTowns.timeSpread;
    costs.byteSpread = kTowns.byteSpread;
    return costs;
  }
  try {
    measureInSmallTown(plan.pipeline, reread, TownClasses::Pipeline, costs);
  } catch (const InputError&) {
    // The pipeline's ontology may lack classes of the town. Another ontology hardly changes the costs.
    measureInSmallTown(plan.pipeline, reread, TownClasses::Own, costs);
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
    return !draws.empty() || objects.findInItems("town") != nullptr;
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
  // The frames of a scene cannot start before the scene is set up. Several scenes are set up at a time, one per thread.
  const double setup =
      std::max(static_cast<double>(scenes) * costs.sceneSeconds / costs.cores, costs.slowestSceneSeconds);
  const double framesPerThread = std::max(static_cast<double>(frames) / costs.threads, 1.0);
  const double seconds = kStartSeconds + setup + framesPerThread * costs.frameSeconds;
  const double bytes = static_cast<double>(frames) * costs.frameBytes;
  const auto within = [](double expected, double spread) {
    return Estimate{expected / spread, expected, expected * spread};
  };
  return {
      .threads = costs.threads, .seconds = within(seconds, costs.timeSpread), .bytes = within(bytes, costs.byteSpread)};
}

}  // namespace scanmill
