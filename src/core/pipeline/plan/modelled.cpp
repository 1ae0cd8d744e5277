// Describes a plan in words: what is modelled, what is left out, and why.

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "config/flow_text.h"
#include "config/named_options.h"
#include "methods/interface/light_paths.h"
#include "pipeline/plan/plan.h"
#include "pipeline/read/drawn_sensors.h"
#include "pipeline/read/effects.h"
#include "scenefile/scene_file.h"
#include "sensors/trajectory.h"

namespace scanmill {

namespace {

// Returns the names of the effects that the pipeline removes, as with `speckle: none`.
std::vector<std::string> leftOutOf(const Pipeline& pipeline) {
  std::vector<std::string> names;
  for (const Value& item : pipeline.effectItems) {
    const NamedOptions named = readNamed(item, "an effect");
    if (named.options.kind == Value::Kind::Scalar && named.options.text == "none") names.push_back(named.name);
  }
  return names;
}

// Adds a line for each effect: separately for each sensor if the pipeline uses the effects of the sensors' files,
// otherwise once for all sensors.
void addEffectLines(const Pipeline& pipeline, std::vector<std::string>& lines) {
  const bool own = takesSensorEffects(pipeline);
  const std::vector<std::string> leftOut = leftOutOf(pipeline);
  for (std::size_t s = 0; s < (own ? pipeline.sensors.size() : 1); ++s) {
    const std::string of = own ? fmt::format(" of '{}'", pipeline.sensors[s].name) : "";
    const Effects& effects = *pipeline.sensors[s].effects;
    if (effects.empty() && pipeline.drawn == nullptr) {
      lines.push_back(fmt::format("effects{}: none, the scans are noise-free", of));
    }
    for (const ChosenEffect& effect : effects) {
      const EffectEntry& entry = *effect.entry;
      if (pipeline.recording != nullptr && (effect->raysPerBeam() > 1 || effect->lightPaths() != nullptr)) {
        lines.push_back(fmt::format("effect {}{}: left out: a recording holds one ray per beam", entry.name, of));
        continue;
      }
      lines.push_back(fmt::format("effect {}{}{}{}: {}", entry.name, of, effect.options.empty() ? "" : " ",
                                  effect.options, entry.summary));
    }
    for (const std::string& name : leftOut) {
      lines.push_back(fmt::format("effect {}{}: left out by the pipeline", name, of));
    }
  }
  for (const MountedSensor& sensor : pipeline.sensors) {
    if (own && sensor.standIn) {
      lines.push_back(fmt::format(
          "effects of the sensor's file of '{}': left out, since its file has none{}", sensor.name,
          sensor.standIn->items.empty() ? "" : "; the intensity of another sensor stands in, without noise"));
    }
    if (own || sensor.description.find("effects") == nullptr) continue;
    lines.push_back(
        fmt::format("effects in the sensor file of '{}': left out (`effects: sensor` uses them)", sensor.name));
  }
}

// Adds lines about classes of the scenes that the ontology named by the pipeline lacks or merges.
void addLabelLines(const Pipeline& pipeline, std::vector<std::string>& lines) {
  if (pipeline.ontology.empty() || pipeline.recording != nullptr) return;
  const Ontology own = readOntology(pipeline.ontology);
  std::set<std::string> told;
  for (const Sequence& s : pipeline.sequences) {
    const Ontology scenes = readSceneOntology(s.sceneFile);
    if (!told.insert(scenes.name).second) continue;
    for (const std::string& line : lostBetween(scenes, own)) {
      lines.push_back(fmt::format("labels: classes of {} replace those of {}: {}", own.name, scenes.name, line));
    }
  }
}

std::string motionLine(const Pipeline& pipeline) {
  if (pipeline.recording != nullptr) return "ego motion: as in the recording";
  switch (pipeline.motion.kind) {
    case MotionKind::None:
      return "ego motion: left out, one pose per revolution";
    case MotionKind::PerColumn:
      return "ego motion: one pose per column";
    case MotionKind::Steps:
      break;
  }
  return fmt::format("ego motion: {} poses per revolution", pipeline.motion.steps);
}

std::string voxelsLine(const Pipeline& pipeline) {
  if (!pipeline.output.voxels)
    return "voxels: left out (`output.voxels: true` adds labelled voxel grids around the sensors)";
  const VoxelGrid& grid = *pipeline.output.voxels;
  return fmt::format("voxels: {} x {} x {} of {:g} m around each sensor, labelled by the area of the triangles in them",
                     grid.counts[0], grid.counts[1], grid.counts[2], grid.size);
}

std::string missesLine(const ScanLayout& layout) {
  if (layout.organised) return "misses: written as NaN";
  const bool beamKnown = layout.columns.has(kRing) && layout.columns.has(kColumn);
  return fmt::format("misses: not written; {}",
                     beamKnown ? "ring and column identify the beam of a point"
                               : "name ring and column in output.columns to know the beam of a point");
}

std::string vehicleLine(const Pipeline& pipeline, std::span<const double> blocked) {
  if (pipeline.vehicle.empty())
    return "own vehicle: left out (`vehicle: vehicle` puts a car of boxes under the sensors)";
  std::string shares;
  for (std::size_t s = 0; s < blocked.size(); ++s) {
    const std::string of = blocked.size() > 1 ? fmt::format(" of '{}'", pipeline.sensors[s].name) : "";
    shares += s > 0 ? ", " : "";
    shares += std::isnan(blocked[s])
                  ? fmt::format("none{}, left out, since its beams change from revolution to revolution", of)
                  : fmt::format("{:.1f} % of the rays{}", 100 * blocked[s], of);
  }
  return fmt::format("own vehicle: {}, blocks {}{}", pipeline.vehicle.filename().string(), shares,
                     pipeline.dropVehicle ? ", which have no return (`returns: drop`)" : "");
}

}  // namespace

std::vector<std::string> modelled(const Plan& plan, std::span<const double> blocked) {
  const Pipeline& pipeline = plan.pipeline;
  const ColumnSet columns = pipeline.output.layout.columns;
  std::vector<std::string> lines;
  lines.push_back(fmt::format("channels: {}", fmt::join(channelNames(plan.channels), ", ")));
  std::string left;
  for (const std::string& name : channelNames(Channels::all())) {
    const auto asked = channelNames(plan.channels);
    if (std::find(asked.begin(), asked.end(), name) == asked.end()) left += (left.empty() ? "" : ", ") + name;
  }
  if (!left.empty())
    lines.push_back(fmt::format("properties of hits that nothing reads, so that they are not computed: {}", left));
  for (const std::string_view column : {"intensity", "power"}) {
    if (!columns.has(columnIndex(column)) || setsIntensity(pipeline)) continue;
    lines.push_back(fmt::format("{}: left out, no effect sets it (add `effects: [intensity]`)", column));
  }
  if (!plan.channels.has(Channel::Reflectance)) {
    lines.emplace_back("reflectance textures: left out, nothing reads the reflectance; only alpha is loaded");
  }
  addLabelLines(pipeline, lines);
  addEffectLines(pipeline, lines);
  if (pipeline.drawn != nullptr) {
    const std::vector<std::string> drawn = pipeline.drawn->lines();
    lines.emplace_back("random values: the lines above have those of the first frame, each sample lists its own");
    lines.insert(lines.end(), drawn.begin(), drawn.end());
  }
  std::set<std::string> takenOut;
  for (const Sequence& s : pipeline.sequences) {
    if (s.without.empty()) continue;
    Value list;
    list.kind = Value::Kind::Sequence;
    list.items = s.without;
    takenOut.insert(fmt::format("removed from {}: {}", s.scene, flowText(list)));
  }
  lines.insert(lines.end(), takenOut.begin(), takenOut.end());
  lines.push_back(motionLine(pipeline));
  std::map<std::string, std::set<std::string>> ways;  // description -> names of trajectories
  for (const Sequence& s : pipeline.sequences) {
    const std::string about = s.trajectory == nullptr ? "" : s.trajectory->about();
    if (!about.empty()) ways[about].insert(s.trajectoryName);
  }
  for (const auto& [about, names] : ways) lines.push_back(fmt::format("path of {}: {}", fmt::join(names, ", "), about));
  if (pipeline.recording == nullptr) lines.push_back(vehicleLine(pipeline, blocked));
  lines.push_back(missesLine(pipeline.output.layout));
  if (pipeline.recording == nullptr) {
    lines.emplace_back(pipeline.output.objects
                           ? "objects: boxes, and visibility by one more ray for each beam that crosses a box"
                           : "objects: left out (`output.objects: true` lists their boxes and visibility)");
    lines.push_back(voxelsLine(pipeline));
  }
  if (!columns.has(kRangeTrue)) {
    lines.emplace_back("range_true: left out (name it in output.columns to keep the noise-free range)");
  }
  return lines;
}

}  // namespace scanmill
