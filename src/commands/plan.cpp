#include "pipeline/plan/plan.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/forecast_text.h"
#include "commands/table.h"
#include "pipeline/checks/warnings.h"
#include "pipeline/plan/shard_jobs.h"
#include "pipeline/scenes/scene_probe.h"
#include "pipeline/scenes/shot_source.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostScenes = 20;  // greatest number of scenes to load; further scenes seldom show other faults

// Prints how many triangles of each file, material and texture have no class, the largest number first.
void printUnlabeled(const std::map<UnlabeledPart, std::uint64_t>& unlabeled) {
  constexpr std::size_t kMostRows = 20;
  if (unlabeled.empty()) return printText("unlabelled geometry: none\n");
  struct Group {  // parts with the same file, material and texture
    std::uint64_t triangles = 0;
    std::set<std::string> nodes;
  };
  std::map<UnlabeledPart, Group> groups;  // the keys have no node
  for (const auto& [part, triangles] : unlabeled) {
    Group& group = groups[{part.file, part.material, part.texture, {}}];
    group.triangles += triangles;
    group.nodes.insert(part.node);
  }
  std::vector<std::pair<UnlabeledPart, Group>> sorted(groups.begin(), groups.end());
  std::ranges::stable_sort(sorted, std::greater<>(), [](const auto& entry) { return entry.second.triangles; });
  printText("unlabelled geometry (no rule gives it a class):\n");
  Rows rows{{"file", "material", "texture", "nodes", "triangles"}};
  for (std::size_t i = 0; i < std::min(sorted.size(), kMostRows); ++i) {
    const auto& [part, group] = sorted[i];
    const std::string& firstNode = *group.nodes.begin();
    const std::size_t otherNodes = group.nodes.size() - 1;
    rows.push_back({part.file, part.material, part.texture,
                    otherNodes == 0 ? firstNode : fmt::format("{} and {} more", firstNode, otherNodes),
                    grouped(group.triangles)});
  }
  printText("{}", formatTable(rows));
  if (sorted.size() > kMostRows)
    printText("and {} more combinations of file, material and texture\n", sorted.size() - kMostRows);
}

// Lists the scene's random choices that depend on the seed, in words: the kind of place, and keys with random values.
std::string randomText(const Scene& scene) {
  std::string words = scene.about;
  for (const DrawnValue& draw : scene.draws) {
    words += fmt::format("{}{} {}", words.empty() ? "" : ", ", draw.key, draw.value);
  }
  return words;
}

// Loads the scenes of a plan, warns of legal but rarely intended contents (paths through things, objects of odd sizes,
// rules that match nothing), and prints a table of the scenes and their unlabelled geometry. run() loads the scenes and
// must be called before print() and mostBytes().
class SceneCheck {
 public:
  explicit SceneCheck(ShotSource& source)
      : source_(source), plan_(source.plan()), modelled_(modelled(plan_, source.blockedShares())) {}

  // Loads only the first kMostScenes scenes.
  void run() {
    const std::vector<Sequence>& sequences = plan_.pipeline.sequences;
    for (std::size_t i = 0; i < sequences.size(); ++i) {
      if (i > 0 && sequences[i].sameScene(sequences[i - 1])) continue;  // checked with the scene's first sequence
      if (rows_.size() > kMostScenes) {
        ++notLoaded_;
      } else {
        load(i);
      }
    }
    for (const std::string& line : warningsOfAllSeeds_) warn(line);
  }

  void print() {
    if (const auto& recording = plan_.pipeline.recording; recording != nullptr) {
      printText("scenes: none, the scans are made from the {} in {}\n\n", nameOf(recording->kind),
                recording->folder.string());
      return;
    }
    // The last column is left out if the seed selects nothing at random in any scene.
    if (std::all_of(rows_.begin() + 1, rows_.end(), [](const auto& row) { return row.back().empty(); })) {
      for (std::vector<std::string>& row : rows_) row.pop_back();
    }
    printText("{}", formatTable(rows_));
    if (notLoaded_ > 0) {
      printText("and {} more scenes, which are checked when the dataset is made\n", grouped(notLoaded_));
    }
    printText("\n");
    printUnlabeled(unlabeled_);
  }

  // Returns the features modelled or left out in all scenes; after run(), also those of only some of the loaded scenes.
  const std::vector<ModelledItem>& modelledItems() const { return modelled_; }
  // Returns the largest memory that the method takes for a scene; 0: it was not measured.
  std::uint64_t mostBytes() const { return mostBytes_; }

 private:
  // Loads and checks the scene of the sequence `first`. Also checks the paths of all consecutive sequences from `first`
  // on that use this scene.
  void load(std::size_t first) {
    const Pipeline& pipeline = plan_.pipeline;
    const Sequence& sequence = pipeline.sequences[first];
    const std::string name = fmt::format("{} seed {}", sequence.scene, sequence.sceneSeed);
    const Scene scene = source_.load(first);
    const auto method = source_.method(scene);
    rows_.push_back({name, grouped(scene.triangles()), grouped(scene.placedTriangles()),
                     grouped(scene.instances.size()), grouped(scene.things()), grouped(scene.materials.size()),
                     grouped(scene.dropped.total()), randomText(scene)});
    for (const std::string& line : damageWarnings(scene)) warn(line);
    for (const std::string& line : sizeWarnings(scene)) warn(line);
    for (const std::string& line : seedWarnings(pipeline, sequence, scene)) warn(line);
    for (const std::string& line : ruleWarnings(scene)) warningsOfAllSeeds_.insert(line);
    for (const std::string& line : withoutWarnings(scene)) warningsOfAllSeeds_.insert(line);
    for (const auto& [part, triangles] : scene.unlabeled) unlabeled_[part] += triangles;
    if (pipeline.recording == nullptr) {
      const SceneProbe probe(scene, method.get(), pipeline.method.entry);
      for (std::size_t k = first; k < pipeline.sequences.size() && pipeline.sequences[k].sameScene(sequence); ++k) {
        for (const std::string& line : pathWarnings(source_, k, probe)) warn(line);
      }
    }
    for (const ModelledItem& item : modelledOf(plan_, sequence, scene, *method)) {
      // If several scenes describe the same feature with different texts, only the first scene's item is kept.
      const auto isAboutSame = [&](const ModelledItem& earlier) {
        return earlier.topic == item.topic && earlier.leftOut == item.leftOut && earlier.sensor == item.sensor;
      };
      if (std::ranges::none_of(modelled_, isAboutSame)) modelled_.push_back(item);
    }
    plan_.checkMemory(method->memoryBytes(), name);
    mostBytes_ = std::max(mostBytes_, method->memoryBytes());
  }

  ShotSource& source_;
  const Plan& plan_;
  std::vector<ModelledItem> modelled_;
  std::uint64_t mostBytes_ = 0;
  Rows rows_{{"scene", "triangles", "placed", "instances", "things", "materials", "dropped", "place"}};
  std::map<UnlabeledPart, std::uint64_t> unlabeled_;  // numbers of triangles
  std::set<std::string> warningsOfAllSeeds_;          // these warnings are printed once, not for each seed
  std::uint64_t notLoaded_ = 0;                       // number of scenes
};

void printSensors(const Plan& plan) {
  Rows rows{{"sensor", "model", "rings", "columns", "beams", "revolutions/s", "range m"}};
  for (std::size_t s = 0; s < plan.sensors.size(); ++s) {
    const BeamTable& b = *plan.sensors[s].beams;
    rows.push_back({plan.pipeline.sensors[s].name, b.model, std::to_string(b.rings), std::to_string(b.columns),
                    grouped(b.size()), fmt::format("{:.3g}", 1 / b.period),
                    fmt::format("{:.3g} to {:.3g}", b.minRange, b.maxRange)});
  }
  printText("{}\n", formatTable(rows));
}

void printSequences(const Pipeline& pipeline) {
  constexpr std::size_t kMostSequences = 40;
  Rows rows{{"sequence", "frames", "split"}};
  for (const Sequence& s : pipeline.sequences) {
    if (rows.size() > kMostSequences) break;
    rows.push_back({s.key(), std::to_string(s.frames), s.split});
  }
  printText("{}", formatTable(rows));
  if (pipeline.sequences.size() > kMostSequences) {
    printText("and {} more sequences\n", grouped(pipeline.sequences.size() - kMostSequences));
  }
  printText("\n");
}

// Returns the numbers of shards in all and per split, such as "6 shards: train 4, val 1, test 1".
std::string shardsOfSplits(const Plan& plan) {
  const std::vector<ShardJob> jobs = shardJobs(plan);
  const std::vector<DatasetPlan::Split> splits = splitsOf(jobs);
  std::string text = pluralOf(jobs.size(), "shard");
  for (std::size_t i = 0; splits.size() > 1 && i < splits.size(); ++i) {
    text += fmt::format("{}{} {}", i == 0 ? ": " : ", ", splits[i].name, grouped(splits[i].shards));
  }
  return text;
}

// Numbers of scenes and frames of a dataset; double, because they may exceed 64 bits.
struct DatasetSize {
  double scenes = 0;
  double frames = 0;
};

// Prints the number of seeds that give at least `frames` frames. Returns the size of the dataset with these seeds. If
// the scenes do not depend on seeds, returns the number of the pipeline's scenes, and `frames`.
DatasetSize printSeeds(const Pipeline& pipeline, double frames) {
  const auto scenes = static_cast<double>(scenesOf(pipeline));
  if (!followsFromSeeds(pipeline)) {
    printText(
        "\nfor {} frames: the scenes are the same for all seeds, so lengthen their trajectories or add trajectories\n",
        grouped(static_cast<std::uint64_t>(frames)));
    return {.scenes = scenes, .frames = frames};
  }
  std::set<std::filesystem::path> files;
  for (const Sequence& sequence : pipeline.sequences) files.insert(sequence.sceneFile);
  const auto fileCount = static_cast<double>(files.size());
  const double framesPerScene = static_cast<double>(pipeline.frames()) / scenes;
  const double seeds = std::max(1.0, std::ceil(frames / framesPerScene / fileCount));  // seeds of each file
  printText("\nfor {} frames: {}{} of {} frames, `seeds: {}`{}\n", grouped(static_cast<std::uint64_t>(frames)),
            pluralOf(static_cast<std::uint64_t>(seeds), "seed"),
            files.size() > 1 ? fmt::format(" of each of the {} scene files", files.size()) : "",
            shortNumber(framesPerScene),
            seeds > 2   ? fmt::format("[1, ..., {:.0f}]", seeds)
            : seeds > 1 ? "[1, 2]"
                        : "[1]",
            pipeline.splitsBySeed ? "; `splits` lists seeds: add the new seeds to it, or give --set splits=null" : "");
  return {.scenes = seeds * fileCount, .frames = seeds * fileCount * framesPerScene};
}

void printForecast(const SampleCosts& costs, const DatasetSize& size) {
  const Forecast f = forecast(costs, static_cast<std::uint64_t>(size.frames), static_cast<std::uint64_t>(size.scenes));
  printText("time: {}\nsize: {}\n", timeText(f), sizeText(f));
}

// Prints what a dataset of at least `frames` frames needs: seeds, time and size (if `costs` are known) and, if it has
// too many rays, the limit of rays.
void printLargerDataset(const Pipeline& pipeline, double frames, const std::optional<SampleCosts>& costs) {
  const DatasetSize size = printSeeds(pipeline, frames);
  if (costs) printForecast(*costs, size);
  const double rays = size.frames * pipeline.rays() / static_cast<double>(pipeline.frames());
  if (rays <= pipeline.maxRays) return;
  printText("these are {} rays, more than `limits.max_rays` allows ({}): give generate --set limits.max_rays={:.0e}\n",
            shortNumber(rays), shortNumber(pipeline.maxRays), 10 * std::pow(10, std::floor(std::log10(rays))));
}

// Returns the value of --frames; 0 if it is not given. Throws InputError if it is not 1 to 1e12, or for recordings.
std::uint64_t framesOption(const Arguments& parsed, const Pipeline& pipeline) {
  if (!parsed.has("frames")) return 0;
  const std::uint64_t frames = countOption(parsed, "frames");
  constexpr std::uint64_t kMostFrames = 1'000'000'000'000;
  if (frames == 0 || frames > kMostFrames) {
    throw InputError(fmt::format("--frames {}: must be a whole number from 1 to {}", frames, kMostFrames));
  }
  if (pipeline.recording != nullptr) {
    throw InputError("--frames: a recording has a fixed number of frames: leave the option out");
  }
  return frames;
}

// Prints the first lines of the output: frames, shards, time and size, and what a dataset of --frames frames needs.
void printSize(const Arguments& parsed, const Plan& plan) {
  const Pipeline& pipeline = plan.pipeline;
  const std::uint64_t frames = framesOption(parsed, pipeline);
  std::optional<SampleCosts> costs;
  std::string problem;
  try {
    costs = sampleCosts(parsed, plan);
  } catch (const Error& error) {
    problem = error.what();
  }
  printText("{} in {}\n", pluralOf(pipeline.frames(), "frame"), shardsOfSplits(plan));
  if (costs) {
    printForecast(*costs, {static_cast<double>(scenesOf(pipeline)), static_cast<double>(pipeline.frames())});
  } else {
    printText(
        "time and size: unknown, since the pipeline's sensors and effects could not scan the small town that forecasts "
        "measure: {}\n",
        problem);
  }
  if (frames > 0) printLargerDataset(pipeline, static_cast<double>(frames), costs);
  printText("\n");
}

// Prints the number of rays, and the memory. `sceneBytes`: memory of the method for a scene; 0: it was not measured.
void printRaysAndMemory(const Plan& plan, std::uint64_t sceneBytes) {
  const Pipeline& pipeline = plan.pipeline;
  const double rays = pipeline.rays();
  const auto perFrame = static_cast<std::uint64_t>(rays / static_cast<double>(pipeline.frames()));
  printText("\n{} frames x {}{} {} = {} rays (limits.max_rays: {})\n", grouped(pipeline.frames()),
            pipeline.oneRevolution() ? "" : "about ", grouped(perFrame),
            pipeline.raysPerFrame() == pipeline.beamsPerFrame() ? "beams" : "rays", shortNumber(rays),
            shortNumber(pipeline.maxRays));
  const auto inFlight = static_cast<double>(plan.framesInFlight()) * static_cast<double>(plan.bytesPerFrameInMemory());
  printText("memory: {} for frames in flight", shortBytes(inFlight));
  if (sceneBytes > 0) printText(" and about {} for the scene", shortBytes(sceneBytes));
  printText("\n");
}

}  // namespace

int runPlan(const std::vector<std::string>& arguments) {
  CommandOptions options("plan");
  options.add("frames", "print also how many seeds a dataset of N frames needs, and its time and size", textValue(),
              "N");
  options.add(
      "check",
      "load the scenes, and warn of paths through things, unlabelled parts, unusual sizes and too little memory");
  addRecordingOptions(options);
  addPipelineOptions(options);
  const Arguments parsed =
      parseArguments(options, arguments,
                     "  scanmill plan pipelines/quickstart.yaml\n"
                     "  scanmill plan pipelines/quickstart.yaml --frames 10000\n"
                     "  scanmill plan pipelines/truck_town.yaml --check    # what its scenes contain\n"
                     "  scanmill plan pipelines/street.yaml --from-hits out/hits\n");
  const Plan plan = makePlan(readPipeline(parsed.pipeline(), pipelineOverrides(parsed), recordingOf(parsed)));
  ShotSource source(plan);
  const Pipeline& pipeline = plan.pipeline;
  for (const std::string& line : vehicleWarnings(pipeline, source.blockedShares())) warn(line);
  for (const std::string& line : sensorWarnings(plan)) warn(line);
  for (const std::string& line : driveWarnings(pipeline)) warn(line);
  printSize(parsed, plan);
  printSensors(plan);
  printSequences(pipeline);

  const bool recorded = pipeline.recording != nullptr;
  const bool checks = parsed.has("check");
  if (recorded && checks) warn("--check needs scenes, but a recording has none: it is ignored");
  SceneCheck scenes(source);
  if (checks || recorded) {
    scenes.run();
    scenes.print();
    printText("\n");
  }
  std::vector<ModelledItem> items = scenes.modelledItems();
  if (!checks && !recorded) {
    items.push_back(
        {"method", fmt::format("{}; --check tells what it leaves out of these scenes", pipeline.methodName())});
  }
  printText("modelled and left out:\n");
  for (const ModelledItem& item : items) printText("  {}\n", lineOf(item));
  printRaysAndMemory(plan, scenes.mostBytes());
  if (checks && !recorded) {
    printText("checked: paths, labels and sizes; {}\n",
              warningCount() == 0 ? "nothing to warn of" : pluralOf(warningCount(), "warning"));
  } else if (!recorded) {
    printText("scenes were not loaded; --check loads them and checks paths, labels and sizes\n");
  }
  return 0;
}

}  // namespace scanmill
