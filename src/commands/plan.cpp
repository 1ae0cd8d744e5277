#include "pipeline/plan/plan.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/grouped.h"
#include "base/parallel.h"
#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/table.h"
#include "evaluate/auto/calibrate.h"
#include "pipeline/plan/dataset_size.h"
#include "pipeline/plan/feature_costs.h"
#include "pipeline/plan/heading_warnings.h"
#include "pipeline/plan/scene_shares.h"
#include "pipeline/plan/warnings.h"
#include "pipeline/plan/way_warnings.h"
#include "pipeline/run/progress.h"
#include "scene/thing_boxes.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostSequences = 40;  // that are listed
constexpr std::size_t kMostScenes = 20;     // that are looked at: others of the same pipeline differ by their seeds

void printSensors(const Plan& plan) {
  std::vector<std::vector<std::string>> rows{
      {"sensor", "model", "rings", "columns", "beams", "revolutions/s", "range m"}};
  for (std::size_t s = 0; s < plan.beams().size(); ++s) {
    const BeamTable& b = *plan.beams()[s];
    rows.push_back({plan.pipeline().sensors[s].name, b.model, std::to_string(b.rings), std::to_string(b.columns),
                    grouped(b.size()), fmt::format("{:.3g}", 1 / b.period),
                    fmt::format("{:.3g} to {:.3g}", b.minRange, b.maxRange)});
  }
  printText("{}\n", formatTable(rows));
}

void printSequences(const Pipeline& pipeline) {
  const auto turns = [](const Sequence& s) { return s.trajectory ? s.trajectory->turns() : std::nullopt; };
  const bool any = std::any_of(pipeline.sequences.begin(), pipeline.sequences.end(),
                               [&](const Sequence& s) { return turns(s).has_value(); });
  std::vector<std::vector<std::string>> rows{{"sequence", "frames", "split", "turns"}};
  for (const Sequence& s : pipeline.sequences) {
    if (rows.size() > kMostSequences) break;
    rows.push_back({s.key(), std::to_string(s.frames), s.split, turns(s) ? std::to_string(*turns(s)) : ""});
  }
  for (std::vector<std::string>& row : rows) row.resize(any ? 4 : 3);
  printText("{}", formatTable(rows));
  if (pipeline.sequences.size() > kMostSequences) {
    printText("and {} sequences more\n", grouped(pipeline.sequences.size() - kMostSequences));
  }
  printText("\n");
}

// By file, material and texture, the largest first.
void printUnlabeled(const std::map<UnlabeledPart, std::uint64_t>& unlabeled) {
  constexpr std::size_t kMostRows = 20;
  if (unlabeled.empty()) {
    printText("unlabelled geometry: none\n");
    return;
  }
  struct Group {
    std::uint64_t triangles = 0;
    std::set<std::string> nodes;
  };
  std::map<UnlabeledPart, Group> groups;
  for (const auto& [part, triangles] : unlabeled) {
    Group& group = groups[{part.file, part.material, part.texture, {}}];
    group.triangles += triangles;
    group.nodes.insert(part.node);
  }
  std::vector<std::pair<UnlabeledPart, Group>> sorted(groups.begin(), groups.end());
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.second.triangles > b.second.triangles; });
  printText("unlabelled geometry (no rule gives it a class):\n");
  std::vector<std::vector<std::string>> rows{{"file", "material", "texture", "nodes", "triangles"}};
  for (std::size_t i = 0; i < std::min(sorted.size(), kMostRows); ++i) {
    const auto& [part, group] = sorted[i];
    const std::string& first = *group.nodes.begin();
    rows.push_back({part.file, part.material, part.texture,
                    group.nodes.size() == 1 ? first : fmt::format("{} and {} more", first, group.nodes.size() - 1),
                    grouped(group.triangles)});
  }
  printText("{}", formatTable(rows));
  if (sorted.size() > kMostRows) printText("and {} more of file, material and texture\n", sorted.size() - kMostRows);
}

// Prints what each feature adds to a frame, in ms and in per cent of the frame. Features whose cost is lost in the
// scatter of equal frames share one line.
void printFeatures(const FeatureCosts& costs) {
  if (costs.points == 0) {
    warn(fmt::format("no beam of {} meets anything: what features cost is not measured", costs.frame));
    return;
  }
  const auto ms = [](double seconds) { return fmt::format("{:.2f}", 1e3 * seconds); };
  std::vector<std::vector<std::string>> rows{
      {"what a feature costs a frame", "trace ms", "effects ms", "encode ms", "all ms", "share", "kB"}};
  const auto add = [&](const std::string& name, const FrameCost& cost, const std::string& share) {
    rows.push_back({name, ms(cost.traceSeconds), ms(cost.effectsSeconds), ms(cost.encodeSeconds), ms(cost.seconds()),
                    share, fmt::format("{:+}", std::lround(cost.bytes * 1e-3))});
  };
  add("as the pipeline is", costs.whole, "");
  std::string lost;
  double scatter = 0;
  for (const FeatureCost& f : costs.features) {
    const std::string name = fmt::format("{}{}", f.feature, f.present ? "" : ", if added");
    if (f.cost.seconds() > f.scatter) {
      add(name, f.cost, fmt::format("{:+.1f} %", 100 * f.cost.seconds() / costs.whole.seconds()));
      continue;
    }
    lost += (lost.empty() ? "" : "; ") + name;
    scatter = std::max({scatter, f.scatter, -f.cost.seconds()});
  }
  printText("\n{}measured on {}: the least times of frames with and without, tracing on all cores, the rest on one\n",
            formatTable(rows), costs.frame);
  if (lost.empty()) return;
  printText("lost in the scatter of equal frames, which is up to {:.0f} %: {}\n", 100 * scatter / costs.whole.seconds(),
            lost);
}

// With a bar on a terminal, which ends before anything else is printed.
FeatureCosts measured(const std::function<Pipeline()>& reread) {
  FeatureEffort effort;
  effort.seconds = 20;
  Progress progress("plan: what features cost", 0, "rounds", "rounds", ::isatty(STDERR_FILENO) == 0);
  effort.begun = [&](int round, int of) {
    progress.setTotal(static_cast<std::uint64_t>(of) + 1);
    if (round > 0) progress.advance(1, 1);
  };
  FeatureCosts costs = measureFeatures(reread, effort);
  progress.advance(1, 1);
  return costs;
}

// What kind of place the seed has drawn.
std::string placeOf(const Scene& scene) {
  std::string words = scene.about;
  for (const DrawnValue& draw : scene.draws) {
    words += fmt::format("{}{} {}", words.empty() ? "" : ", ", draw.key, draw.value);
  }
  return words;
}

}  // namespace

int runPlan(const std::vector<std::string>& arguments) {
  const Command& command = commandNamed("plan");
  cxxopts::Options options = describe(command);
  options.add_options()("costs", "measure what each feature costs, which traces a frame some hundred times");
  addRecordingOptions(options);
  addPipelineOptions(options);
  const Arguments parsed =
      parseArguments(command, options, arguments,
                     "  scanmill plan pipelines/truck_town.yaml\n"
                     "  scanmill plan pipelines/street.yaml --costs    # what each effect and column costs\n"
                     "  scanmill plan pipelines/street.yaml --from-hits out/hits\n");
  if (parsed.help) return 0;
  const ResourceLimits limits(parsed);
  const Plan plan(readPipeline(parsed.pipeline(), pipelineOverrides(parsed), recordingOf(parsed)));
  const Pipeline& pipeline = plan.pipeline();
  checkAutoChoice(pipeline);
  for (const std::string& line : vehicleWarnings(plan)) warn(line);
  for (const std::string& line : driveWarnings(pipeline)) warn(line);
  printSensors(plan);
  printSequences(pipeline);

  std::vector<std::vector<std::string>> scenes{
      {"scene", "triangles", "placed", "instances", "things", "materials", "dropped", "place"}};
  std::map<UnlabeledPart, std::uint64_t> unlabeled;
  std::set<std::string> rules;  // what is said of them, once for all seeds
  std::vector<std::string> modelled = plan.modelled();
  std::uint64_t sceneBytes = 0;
  std::size_t things = 0;
  std::uint64_t more = 0;  // scenes
  Ontology ontology;
  for (std::size_t i = 0; i < pipeline.sequences.size(); ++i) {
    const Sequence& s = pipeline.sequences[i];
    if (i > 0 && s.sameScene(pipeline.sequences[i - 1])) continue;  // its ways were looked at with those of the first
    if (scenes.size() > kMostScenes) {
      ++more;
      continue;
    }
    const std::string name = fmt::format("{} seed {}", s.scene, s.sceneSeed);
    const Scene scene = plan.loadScene(s);
    const auto method = pipeline.method.automatic ? nullptr : plan.makeMethod(scene);
    scenes.push_back({name, grouped(scene.triangles()), grouped(scene.placedTriangles()),
                      grouped(scene.instances.size()), grouped(scene.things()), grouped(scene.materials.size()),
                      grouped(scene.dropped.total()), placeOf(scene)});
    for (const std::string& line : damageWarnings(scene)) warn(line);
    for (const std::string& line : sizeWarnings(scene)) warn(line);
    for (const std::string& line : thingSizeWarnings(scene)) warn(line);
    for (const std::string& line : seedWarnings(pipeline, s, scene)) warn(line);
    for (const std::string& line : shareWarnings(scene)) warn(line);
    for (const std::string& line : ruleWarnings(scene)) rules.insert(line);
    for (const std::string& line : withoutWarnings(scene)) rules.insert(line);
    if (pipeline.objects) {
      for (const std::string& line : headingWarnings(scene, ThingBoxes(scene))) warn(line);
    }
    if (pipeline.recording == nullptr) {
      const SceneProbe probe(scene, method.get(), pipeline.method.entry);
      for (std::size_t k = i; k < pipeline.sequences.size() && pipeline.sequences[k].sameScene(s); ++k) {
        for (const std::string& line : wayWarnings(plan, k, probe)) warn(line);
      }
    }
    for (const auto& [what, triangles] : scene.unlabeled) unlabeled[what] += triangles;
    ontology = scene.ontology;
    if (method == nullptr) continue;
    // Counts differ from scene to scene: what is said of one feature is said once, of the first that has it.
    for (const std::string& line : method->modelled()) {
      const auto feature = [](const std::string& text) { return text.substr(0, text.find(':')); };
      const auto isSame = [&](const std::string& known) {
        return feature(known) == feature(line) &&
               (known.find("left out") == known.npos) == (line.find("left out") == line.npos);
      };
      if (std::none_of(modelled.begin(), modelled.end(), isSame)) modelled.push_back(line);
    }
    plan.checkMemory(method->memoryBytes(), name);
    if (pipeline.objects) things = std::max(things, ThingBoxes(scene).things().size());
    sceneBytes = std::max(sceneBytes, method->memoryBytes());
  }
  for (const std::string& line : rules) warn(line);
  // Procedural towns alone are some kind of place.
  const bool places =
      std::any_of(scenes.begin() + 1, scenes.end(), [](const auto& row) { return !row.back().empty(); });
  for (std::vector<std::string>& row : scenes) row.resize(places ? row.size() : row.size() - 1);
  if (pipeline.recording == nullptr) {
    printText("{}", formatTable(scenes));
    if (more > 0) printText("and {} scenes more, which are looked at when the dataset is made\n", grouped(more));
    printText("\n");
  } else {
    printText("scenes: none, the scans are made of the {} in {}\n\n", nameOf(pipeline.recording->kind),
              pipeline.recording->folder.string());
  }

  if (pipeline.method.automatic) {
    modelled.push_back(fmt::format("method: auto, one of {} settings, chosen when the dataset is made",
                                   readAutoChoice(pipeline).settings.size()));
  }
  printText("modelled and left out:\n");
  for (const std::string& line : modelled) printText("  {}\n", line);
  if (pipeline.recording == nullptr) {
    printText("\n");
    printUnlabeled(unlabeled);
    if (parsed.options.count("costs") > 0 && !pipeline.method.automatic) {
      printFeatures(measured([&] { return readPipeline(parsed.pipeline(), pipelineOverrides(parsed)); }));
    }
  }
  const auto rays = static_cast<double>(pipeline.frames()) * static_cast<double>(pipeline.raysPerFrame());
  const auto inFlight = static_cast<double>(plan.framesInFlight()) * static_cast<double>(plan.bytesPerFrameInMemory());
  printText("\n{} frames x {} {} = {} rays ({} allowed)\n", grouped(pipeline.frames()),
            grouped(pipeline.raysPerFrame()), pipeline.raysPerFrame() == pipeline.beamsPerFrame() ? "beams" : "rays",
            shortNumber(rays), shortNumber(pipeline.maxRays));
  printText("memory: {} for the scene and {} for frames in flight\n",
            pipeline.method.automatic ? "what the chosen method takes"
                                      : "about " + shortBytes(static_cast<double>(sceneBytes)),
            shortBytes(inFlight));
  printText("disk: at most about {}\n", shortBytes(mostDatasetBytes(plan, ontology, things)));
  return 0;
}

}  // namespace scanmill
