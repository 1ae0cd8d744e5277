#include "pipeline/checks/warnings.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "base/append_new.h"
#include "base/short_text.h"
#include "pipeline/read/effects.h"
#include "scenefile/rules.h"
#include "sensors/trajectory.h"

namespace scanmill {

namespace {

// Usual sizes of meshes (m), in general and of meshes that are one thing, such as a car. Other sizes cause a warning.
constexpr Range kUsualExtent{1e-3, 5000};
constexpr Range kUsualThingExtent{0.01, 300};
constexpr std::size_t kMostLines = 5;      // largest number of lines for warnings of the same kind
constexpr double kLeastTown = 30;          // m; a mesh of at least this size probably contains several things
constexpr std::size_t kFewestNodes = 3;    // as many nodes of one class in a single instance cause a warning
constexpr double kMostBlockedShare = 0.5;  // blocked fraction of a sensor's rays that causes a warning
constexpr double kPeriodRounding = 1e-6;   // tolerance for rounding errors, as a fraction of a period

// Returns the longest edge (m) of a mesh's bounding box, which is computed in the mesh's frame and scaled by `linear`.
// A rotation does not change this edge.
double largestExtent(const Box& box, const Mat3& linear) {
  const Vec3d size = box.high - box.low;
  return std::max({size.x * length(linear * Vec3d{1, 0, 0}), size.y * length(linear * Vec3d{0, 1, 0}),
                   size.z * length(linear * Vec3d{0, 0, 1})});
}

// Returns the first kMostLines lines and, if there are more lines, a line such as "scene a: 7 more `description`".
std::vector<std::string> shortened(std::vector<std::string> lines, const Scene& scene, std::string_view description) {
  if (lines.size() <= kMostLines) return lines;
  const std::size_t hidden = lines.size() - kMostLines;
  lines.resize(kMostLines);
  lines.push_back(fmt::format("scene {}: {} more {}", scene.name, hidden, description));
  return lines;
}

// Returns a warning if the time between the frames of a sequence is shorter than a revolution of the slowest sensor,
// otherwise an empty text. The warning does not contain the name of the drive, so that drives can share it.
std::string intervalWarning(const Pipeline& pipeline, const Sequence& sequence) {
  const double interval = sequence.trajectory->interval();
  const double period = pipeline.periods.longest;
  if (interval >= period * (1 - kPeriodRounding)) return {};
  const auto slowest = std::ranges::find(pipeline.sensors, period, &MountedSensor::period);
  const std::string text =
      fmt::format("are {:g} s apart, but a revolution of '{}' takes {:g} s", interval, slowest->name, period);
  if (sequence.turnsWithoutBreak(pipeline.periods)) {
    return fmt::format("{}: some samples have no scan of it (`every_s: {:g}` gives each sample one)", text, period);
  }
  return fmt::format(
      "{}: its revolutions overlap, as those of a real sensor cannot (`every_s: {:g}` makes one follow the other)",
      text, period);
}

// Warns of values that effects assume because the sensor's file lacks them, and of the effect weather if the effect
// intensity has its default near range.
std::vector<std::string> effectWarnings(const Effects& effects, const MountedSensor& sensor, const BeamTable& beams) {
  constexpr double kDefaultNearRange = 1;  // m, of the effect intensity
  std::vector<std::string> lines;
  bool hasWeather = false;
  double nearRange = 0;  // m; 0: no effect makes the power fall with the squared range
  for (const ChosenEffect& effect : effects) {
    hasWeather |= effect.entry->name == "weather";
    const std::optional<Falloff> falloff = effect->falloff();
    if (falloff && falloff->inverseSquare) nearRange = falloff->near;
    const std::string assumed = effect->assumed(beams);
    if (assumed.empty()) continue;
    lines.push_back(
        fmt::format("effect {}: the file of the sensor '{}' does not give {}: this value is assumed; add "
                    "the data sheet's to the sensor",
                    effect.entry->name, sensor.name, assumed));
  }
  if (hasWeather && nearRange == kDefaultNearRange) {
    lines.push_back(fmt::format(
        "effect weather: the sensor '{}' has the default `near_range_m: 1` in its effect intensity, with which "
        "particles in the first metres give many returns: the presets have 7 to 25 m, so set it",
        sensor.name));
  }
  return lines;
}

}  // namespace

std::vector<std::string> damageWarnings(const Scene& scene) {
  std::vector<std::string> lines;
  const auto addWarning = [&](std::uint64_t triangles, const char* reason) {
    if (triangles == 0) return;
    lines.push_back(fmt::format("scene {}: {} {} left out because of {}: is a file damaged?", scene.name,
                                pluralOf(triangles, "triangle"), triangles == 1 ? "is" : "are", reason));
  };
  addWarning(scene.dropped.nonFinite, "corners that are NaN or infinite");
  addWarning(scene.dropped.outOfRange, "corner indices that are out of range");
  return lines;
}

std::vector<std::string> sizeWarnings(const Scene& scene) {
  std::vector<Box> boxes;
  for (const Mesh& mesh : scene.meshes) boxes.push_back(mesh.bounds());
  std::vector<std::string> lines;
  std::set<std::uint32_t> reported;
  for (const Instance& instance : scene.instances) {
    const Box& box = boxes[instance.mesh];
    const Mesh& mesh = scene.meshes[instance.mesh];
    if (box.empty() || reported.contains(instance.mesh)) continue;
    const double extent = largestExtent(box, instance.worldFromMesh.linear);
    const bool isThing =
        mesh.objects == 1 && std::ranges::all_of(mesh.surfaces, [](const Surface& s) { return s.object != 0; });
    if ((isThing ? kUsualThingExtent : kUsualExtent).contains(extent)) continue;
    reported.insert(instance.mesh);
    lines.push_back(
        fmt::format("scene {}: the object '{}' measures {}: is its `unit` right? (0.001 for millimetres, 0.01 "
                    "for centimetres, 1 for metres)",
                    scene.name, instance.name, shortLength(extent)));
  }
  return shortened(std::move(lines), scene, "objects have such sizes");
}

std::vector<std::string> unlabeledWarnings(const Scene& scene) {
  if (scene.unlabeled.empty()) return {};
  std::uint64_t triangles = 0;
  std::set<std::string> files;
  for (const auto& [part, count] : scene.unlabeled) {
    triangles += count;
    files.insert(part.file);
  }
  const std::string otherFiles = files.size() == 1 ? "" : fmt::format(" and {} more", files.size() - 1);
  return {fmt::format(
      "scene {}: no rule gives a class to {} triangles of {}{}: their points are unlabeled (`scanmill plan --check` "
      "lists them)",
      scene.name, grouped(triangles), *files.begin(), otherFiles)};
}

std::vector<std::string> withoutWarnings(const Scene& scene) {
  if (scene.unreduced == nullptr || scene.unreduced->absent.empty()) return {};
  return {fmt::format("{}: `without` names {}, of which the scene has nothing", scene.file.string(),
                      fmt::join(scene.unreduced->absent, ", "))};
}

std::vector<std::string> ruleWarnings(const Scene& scene) {
  std::vector<std::string> lines;
  for (const RuleUse& rule : scene.rules) {
    if (rule.decided > 0) continue;
    lines.push_back(rule.matched == 0 ? fmt::format("{}: the rule for {} matches nothing: `scanmill info FILE` lists "
                                                    "the names of a file",
                                                    rule.where.text(), rule.match)
                                      : fmt::format("{}: the rule for {} has no effect: earlier rules label all {} "
                                                    "triangles that it matches",
                                                    rule.where.text(), rule.match, rule.matched));
  }
  lines = shortened(std::move(lines), scene, "rules match nothing or have no effect");
  for (const Mesh& mesh : scene.meshes) {
    if (mesh.objects != 1 || largestExtent(mesh.bounds(), {}) < kLeastTown) continue;
    std::map<std::uint16_t, std::set<std::string>> nodesByClass;
    for (const Surface& s : mesh.surfaces) {
      if (s.object != 0) nodesByClass[s.semantic].insert(s.node);
    }
    for (const auto& [id, names] : nodesByClass) {
      if (names.size() < kFewestNodes) continue;
      lines.push_back(
          fmt::format("scene {}: {} nodes of the class {} in '{}' share one instance id: `instances: node` gives each "
                      "its own, and `part` each group of connected triangles, if one thing has several nodes",
                      scene.name, names.size(), scene.ontology.find(id)->name, mesh.name));
    }
  }
  return lines;
}

std::vector<std::string> seedWarnings(const Pipeline& pipeline, const Sequence& sequence, const Scene& scene) {
  if (scene.procedural) return {};
  std::set<std::uint64_t> seeds;
  std::set<std::string> splits;
  for (const Sequence& s : pipeline.sequences) {
    if (s.sceneFile != sequence.sceneFile) continue;
    seeds.insert(s.sceneSeed);
    splits.insert(s.split);
  }
  if (seeds.size() < 2) return {};
  const bool leaks = splits.size() > 1 && pipeline.splitsBySeed;
  return {fmt::format(
      "scene {}: nothing in the scene is procedural, so its {} seeds give the same geometry{}", scene.name,
      seeds.size(),
      leaks ? ", and `splits: {by: seed}` puts this geometry into several splits: list the scene's seeds in one split"
            : "")};
}

std::vector<std::string> driveWarnings(const Pipeline& pipeline) {
  std::vector<std::string> lines;
  std::set<std::string> reported;
  std::map<std::string, std::set<std::string>> drivesByWarning;  // names of drives, by intervalWarning()
  std::size_t turningDrives = 0;                                 // drives with `along: turns`
  std::size_t straightDrives = 0;                                // number of these drives that have no turn
  for (const Sequence& s : pipeline.sequences) {
    if (s.trajectory == nullptr) continue;
    if (s.trajectory->turns()) ++turningDrives;
    if (s.trajectory->turns() == 0) ++straightDrives;
    const std::string interval = intervalWarning(pipeline, s);
    if (!interval.empty()) drivesByWarning[interval].insert(s.trajectoryName);
    const std::string implausible = s.trajectory->warning();
    if (!implausible.empty() && reported.insert(s.trajectoryName).second) {
      lines.push_back(fmt::format("the recorded drive '{}': {}", s.trajectoryName, implausible));
    }
  }
  for (const auto& [interval, drives] : drivesByWarning) {
    const std::string otherDrives = drives.size() == 1 ? "" : " and " + pluralOf(drives.size() - 1, "more drive");
    lines.push_back(fmt::format("frames of '{}'{} {}", *drives.begin(), otherDrives, interval));
  }
  if (turningDrives == 0 || straightDrives < turningDrives) return lines;
  lines.emplace_back(
      "no drive with `along: turns` turns: the towns have no side road to turn out of or into; other seeds may have "
      "one");
  return lines;
}

std::vector<std::string> sensorWarnings(const Plan& plan) {
  const Pipeline& pipeline = plan.pipeline;
  std::vector<std::string> lines;
  for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
    const MountedSensor& sensor = pipeline.sensors[s];
    for (const Effects* const effects : pipeline.effectCases(s)) {
      appendNew(effectWarnings(*effects, sensor, *plan.sensors[s].beams), lines);
    }
    const Value* const effects = sensor.description.find("effects");
    const bool isInPipeline = effects != nullptr && effects->where.file == pipeline.file.string();
    if (isInPipeline && pipeline.drawn == nullptr && !takesSensorEffects(pipeline)) {
      lines.push_back(fmt::format(
          "{}:{}: the effects of the sensor '{}' are not applied, because the pipeline's own `effects` do not name "
          "`sensor`: write `effects: sensor`, or remove them here",
          effects->where.file, effects->where.line, sensor.name));
    }
  }
  return lines;
}

std::vector<std::string> vehicleWarnings(const Pipeline& pipeline, const std::vector<double>& blocked) {
  std::vector<std::string> lines;
  for (std::size_t s = 0; s < blocked.size(); ++s) {
    if (!(blocked[s] >= kMostBlockedShare)) continue;
    const MountedSensor& sensor = pipeline.sensors[s];
    const Vec3d& mount = sensor.vehicleFromSensor.translation;
    lines.push_back(fmt::format(
        "the ego vehicle blocks {:.0f} % of the rays of '{}', which is mounted at [{:g}, {:g}, "
        "{:g}] m: is the sensor inside the vehicle? See `scanmill info` of the vehicle's scene, and `mount`",
        100 * blocked[s], sensor.name, mount.x, mount.y, mount.z));
  }
  return lines;
}

}  // namespace scanmill
