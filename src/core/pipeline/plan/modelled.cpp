// Describes a plan in words: what is modelled, what is left out, and why.

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "config/fields.h"
#include "config/value.h"
#include "methods/interface/light_paths.h"
#include "pipeline/plan/plan.h"
#include "pipeline/read/drawn_sensors.h"
#include "pipeline/read/effects.h"
#include "scenefile/scene_file.h"
#include "sensors/trajectory.h"

namespace scanmill {

namespace {

ModelledItem leftOut(std::string topic, std::string text, std::string sensor = {}) {
  return {.topic = std::move(topic), .text = std::move(text), .leftOut = true, .sensor = std::move(sensor)};
}

// Adds an item for each effect: separately for each sensor if the pipeline uses the effects of the sensors' files,
// otherwise once for all sensors.
void addEffects(const Pipeline& pipeline, std::vector<ModelledItem>& items) {
  const bool perSensor = takesSensorEffects(pipeline);
  for (std::size_t s = 0; s < (perSensor ? pipeline.sensors.size() : 1); ++s) {
    const std::string sensor = perSensor ? pipeline.sensors[s].name : "";  // empty: all sensors
    const Effects& effects = *pipeline.sensors[s].effects;
    if (effects.empty() && pipeline.drawn == nullptr) {
      items.push_back({.topic = "effects", .text = "none, the scans are noise-free", .sensor = sensor});
    }
    for (const ChosenEffect& effect : effects) {
      const std::string topic = fmt::format("effect {}", effect.entry->name);
      if (pipeline.recording != nullptr && (effect->raysPerBeam() > 1 || effect->lightPaths() != nullptr)) {
        items.push_back(leftOut(topic, "a recording holds one ray per beam", sensor));
        continue;
      }
      items.push_back(
          {.topic = topic, .text = std::string(effect.entry->summary), .sensor = sensor, .options = effect.options});
    }
    for (const Value& item : pipeline.effectItems) {
      const NamedOptions named = readNamed(item, "an effect");
      if (named.options.kind != Value::Kind::Scalar || named.options.text != "none") continue;
      items.push_back(leftOut("effect " + named.name, "the pipeline removes it", sensor));
    }
  }
  for (const MountedSensor& sensor : pipeline.sensors) {
    if (perSensor || sensor.description.find("effects") == nullptr) continue;
    items.push_back(leftOut("effects of the sensor's file", "(`effects: sensor` uses them)", sensor.name));
  }
}

// Adds items about the scenes' classes that are absent or merged in the ontology that the pipeline names.
void addLabels(const Pipeline& pipeline, std::vector<ModelledItem>& items) {
  if (pipeline.ontology.empty() || pipeline.recording != nullptr) return;
  const Ontology ontology = readOntology(pipeline.ontology);
  std::set<std::string> reported;
  for (const Sequence& s : pipeline.sequences) {
    const Ontology sceneOntology = readSceneOntology(s.sceneFile);
    if (!reported.insert(sceneOntology.name).second) continue;
    for (const std::string& line : lostBetween(sceneOntology, ontology)) {
      items.push_back(
          {"labels", fmt::format("classes of {} replace those of {}: {}", ontology.name, sceneOntology.name, line)});
    }
  }
}

ModelledItem revolutions(const Pipeline& pipeline) {
  std::vector<std::string> counts;
  for (const MountedSensor& sensor : pipeline.sensors) {
    counts.push_back(fmt::format("{} of '{}'", sensor.revolutions, sensor.name));
  }
  return {"revolutions in a sample", fmt::format("at most {}", fmt::join(counts, ", "))};
}

ModelledItem egoMotion(const Pipeline& pipeline) {
  constexpr const char* kTopic = "ego motion";
  if (pipeline.recording != nullptr) return {kTopic, "as in the recording"};
  if (pipeline.motion.kind == MotionKind::None) return leftOut(kTopic, "one pose per revolution");
  if (pipeline.motion.kind == MotionKind::PerColumn) return {kTopic, "one pose per column"};
  return {kTopic, fmt::format("{} poses per revolution", pipeline.motion.steps)};
}

ModelledItem objects(const std::optional<ListedObjects>& listed) {
  if (!listed) return leftOut("objects", "(`output.objects: true` lists the boxes and visibility of road users)");
  const std::string classes =
      listed->classes.empty() ? "road users, or of all things if no class is one (`objects: {classes: all}` lists all)"
                              : fmt::format("{}", fmt::join(listed->classes, ", "));
  return {"objects", "boxes and visibility of " + (listed->all ? "all things" : classes)};
}

ModelledItem voxels(const Pipeline& pipeline) {
  if (!pipeline.output.voxels) {
    return leftOut("voxels", "(`output.voxels: true` adds labelled voxel grids around the sensors)");
  }
  const VoxelGrid& grid = *pipeline.output.voxels;
  return {"voxels",
          fmt::format("{} x {} x {} of {:g} m around each sensor, labelled by the area of the triangles in them",
                      grid.counts[0], grid.counts[1], grid.counts[2], grid.size)};
}

ModelledItem misses(const ScanLayout& layout) {
  if (layout.organised) return {"misses", "written as NaN"};
  const bool namesBeam = layout.columns.has(kRing) && layout.columns.has(kColumn);
  return {"misses", fmt::format("not written; {}",
                                namesBeam ? "ring and column identify the beam of a point"
                                          : "name ring and column in output.columns to know the beam of a point")};
}

// Returns the name of each sensor and whether its beams continue behind glass and off mirrors. If this is the same for
// all sensors, returns one entry with an empty name.
std::vector<std::pair<std::string, bool>> lightFollowing(const Pipeline& pipeline) {
  std::vector<std::pair<std::string, bool>> sensors;
  for (std::size_t s = 0; s < pipeline.sensors.size(); ++s) {
    sensors.emplace_back(pipeline.sensors[s].name, pipeline.lightPaths(s) != nullptr);
  }
  const bool follows = sensors.front().second;
  const bool agree = std::ranges::all_of(sensors, [&](const auto& sensor) { return sensor.second == follows; });
  return agree ? std::vector{std::pair(std::string(), follows)} : sensors;
}

ModelledItem egoVehicle(const Pipeline& pipeline, std::span<const double> blockedShares) {
  if (pipeline.vehicle.empty()) {
    return leftOut("own vehicle", "(`vehicle: vehicle` puts a car of boxes under the sensors)");
  }
  std::string shares;
  for (std::size_t s = 0; s < blockedShares.size(); ++s) {
    const std::string ofSensor = blockedShares.size() > 1 ? fmt::format(" of '{}'", pipeline.sensors[s].name) : "";
    shares += s > 0 ? ", " : "";
    shares += fmt::format("{:.1f} % of the rays{}", 100 * blockedShares[s], ofSensor);
  }
  return {"own vehicle", fmt::format("{}, blocks {}{}", pipeline.vehicle.filename().string(), shares,
                                     pipeline.dropVehicle ? ", which have no return (`returns: drop`)" : "")};
}

}  // namespace

std::vector<ModelledItem> modelled(const Plan& plan, std::span<const double> blockedShares) {
  const Pipeline& pipeline = plan.pipeline;
  const ColumnSet columns = pipeline.output.layout.columns;
  std::vector<ModelledItem> items;
  items.push_back({"channels", fmt::format("{}", fmt::join(channelNames(plan.channels), ", "))});
  std::vector<std::string> unread = channelNames(Channels::all());
  for (const std::string& channel : channelNames(plan.channels)) std::erase(unread, channel);
  if (!unread.empty()) {
    items.push_back(leftOut("properties of hits that nothing reads", fmt::format("{}", fmt::join(unread, ", "))));
  }
  for (const std::string_view column : {"intensity", "power"}) {
    if (!columns.has(columnIndex(column)) || setsIntensity(pipeline)) continue;
    items.push_back(leftOut(std::string(column), "no effect sets it (add `effects: [intensity]`)"));
  }
  if (!plan.channels.has(Channel::Reflectance)) {
    items.push_back(leftOut("reflectance textures", "nothing reads the reflectance; only alpha is loaded"));
  }
  addLabels(pipeline, items);
  addEffects(pipeline, items);
  if (pipeline.recording == nullptr) {
    for (const auto& [sensor, follows] : lightFollowing(pipeline)) {
      if (follows) continue;
      items.push_back(leftOut("light through glass and off mirrors",
                              "so that glass is opaque (the effect light_paths adds both, by ray tracing)", sensor));
    }
  }
  if (pipeline.drawn != nullptr) {
    items.push_back({"random values", "the lines above have those of the first frame, each sample lists its own"});
    for (ModelledItem& item : pipeline.drawn->items()) items.push_back(std::move(item));
  }
  std::set<std::string> removedObjects;
  std::map<std::string, std::set<std::string>> trajectoriesByPath;  // description -> names of trajectories
  for (const Sequence& s : pipeline.sequences) {
    const std::string description = s.trajectory == nullptr ? "" : s.trajectory->about();
    if (!description.empty()) trajectoriesByPath[description].insert(s.trajectoryName);
    if (s.without.empty()) continue;
    const Value removed = sequenceValue(s.without);
    removedObjects.insert(fmt::format("the pipeline removes {} from {}", flowText(removed), s.scene));
  }
  for (const std::string& text : removedObjects) items.push_back(leftOut("objects of scenes", text));
  if (!pipeline.oneRevolution()) items.push_back(revolutions(pipeline));
  items.push_back(egoMotion(pipeline));
  for (const auto& [description, names] : trajectoriesByPath)
    items.push_back({fmt::format("path of {}", fmt::join(names, ", ")), description});
  if (pipeline.recording == nullptr) items.push_back(egoVehicle(pipeline, blockedShares));
  items.push_back(misses(pipeline.output.layout));
  if (pipeline.recording == nullptr) {
    items.push_back(objects(pipeline.output.objects));
    items.push_back(voxels(pipeline));
  }
  if (!columns.has(kRangeTrue)) {
    items.push_back(leftOut("range_true", "(name it in output.columns to keep the noise-free range)"));
  }
  return items;
}

std::vector<ModelledItem> modelledOf(const Plan& plan, const Sequence& sequence, const Scene& scene,
                                     const Method& method) {
  std::vector<ModelledItem> items = method.modelled();
  std::uint64_t panes = 0;
  for (const Mesh& mesh : scene.meshes) {
    for (const Surface& surface : mesh.surfaces) panes += scene.materials[surface.material].transmission > 0 ? 1 : 0;
  }
  if (panes > 0 && plan.pipeline.recording == nullptr) {
    for (const auto& [sensor, follows] : lightFollowing(plan.pipeline)) {
      items.push_back({.topic = "parts that let light through",
                       .text = follows ? "beams continue behind them" : "opaque here",
                       .leftOut = !follows,
                       .sensor = sensor,
                       .parts = panes});
    }
  }
  for (ModelledItem& item : items) item.scenes = {sequence.sceneName()};
  return items;
}

}  // namespace scanmill
