// Reads pipelines, whose keys docs/keys.md lists.

#include "pipeline/read/pipeline.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/file.h"
#include "base/input_budget.h"
#include "base/random.h"
#include "config/resources.h"
#include "dataset/split.h"
#include "pipeline/read/drawn_sensors.h"
#include "pipeline/read/effects.h"
#include "scenefile/scene_file.h"
#include "sensors/trajectory.h"

namespace scanmill {

namespace {

constexpr double kDefaultMaxRays = 1e11;
constexpr double kTypicalRaysPerSecond = 20e6;  // for the message about too many rays
constexpr std::size_t kMostSensors = 4095;

// Returns a text with "# " inserted at the start of each line but the first, so that it can follow "# " in a comment.
std::string commented(const std::string& text) {
  std::string comment;
  for (const char c : text) {
    comment += c == '\r' ? '\n' : c;
    if (comment.back() == '\n') comment += "# ";
  }
  return comment;
}

// Returns the recording's sensor with the name of `sensor`. Throws InputError at `where` if no sensor has the name, or
// if the numbers of rings and columns differ, since recorded hits or images fit only the recorded sensor's beams.
const RecordedSensor& recordedSensor(const Recording& recording, const MountedSensor& sensor, const Location& where) {
  std::vector<std::string> recordedNames;
  for (const RecordedSensor& recorded : recording.sensors) {
    recordedNames.push_back(recorded.name);
    if (recorded.name != sensor.name) continue;
    if (recorded.rings == sensor.size.rings && recorded.columns == sensor.size.columns) return recorded;
    throw InputError(where, "the sensor '{}' has {} x {} beams, but the recording in {} has {} x {} of it", sensor.name,
                     sensor.size.rings, sensor.size.columns, recording.folder.string(), recorded.rings,
                     recorded.columns);
  }
  throw InputError(where, "the recording in {} has no sensor '{}'{}", recording.folder.string(), sensor.name,
                   suggestion(sensor.name, recordedNames));
}

// Sets the sensors' mounts to the recorded mounts. Throws InputError if the pipeline has other sensors or mounts.
void takeRecordedMounts(Pipeline& pipeline, const Recording& recording, const Value& list) {
  for (std::size_t i = 0; i < pipeline.sensors.size(); ++i) {
    MountedSensor& sensor = pipeline.sensors[i];
    const std::optional<Pose>& recorded = recordedSensor(recording, sensor, list.where).vehicleFromSensor;
    if (!recorded) continue;
    const Value* mount = list.items[i].find("mount");
    if (mount != nullptr && sensor.vehicleFromSensor != *recorded) {
      const Vec3d& position = recorded->translation;
      throw InputError(mount->where,
                       fmt::format("the mount of the sensor '{}' differs from that of the recording in {}, which is at "
                                   "[{:g}, {:g}, {:g}]: recorded hits cannot be moved, so leave out `mount`",
                                   sensor.name, recording.folder.string(), position.x, position.y, position.z));
    }
    sensor.vehicleFromSensor = *recorded;
  }
}

// Returns a sensor's name, which becomes part of file names: the key `name` or, without the key, `fallback`. Throws
// InputError if the name is empty, has characters that file names do not have, or is the name of an `earlier` sensor.
std::string readSensorName(Fields& fields, const std::string& fallback, const std::vector<MountedSensor>& earlier) {
  std::string name = fields.text("name", fallback);
  const Value* const nameValue = fields.find("name");
  if (name.empty())
    throw InputError(nameValue->where, "a sensor's name becomes part of file names, so it must not be empty");
  if (name != keyPart(name)) {
    throw InputError(nameValue->where,
                     fmt::format("a sensor's name becomes part of file names: use lower-case letters, "
                                 "digits, '-' and '_', such as '{}'",
                                 keyPart(name)));
  }
  if (std::ranges::any_of(earlier, [&](const MountedSensor& sensor) { return sensor.name == name; })) {
    throw InputError(fields.where(), "two sensors are named '{}'", name);
  }
  return name;
}

// Reads the key `sensors`. Distributions are replaced by the values of the first frame of the first sequence; the
// values with their distributions are stored in `written`.
std::vector<MountedSensor> readSensors(Fields& fields, std::uint64_t seed, const std::filesystem::path& vehicle,
                                       DrawnSensors::Written& written) {
  std::vector<DrawnValue> ignored;
  const auto sampled = [&](const Value& value, const std::string& key) {  // without distributions
    return withDraws(value, key, {.seed = seed}, ignored);
  };
  std::vector<MountedSensor> sensors;
  const auto add = [&](const Value& item, const std::string& key) -> MountedSensor& {
    Fields sensorFields(item, "sensor");
    MountedSensor sensor;
    sensor.key = key;
    sensor.description = resolveSensor(item);
    sensor.name = readSensorName(sensorFields, fmt::format("lidar{}", sensors.size()), sensors);
    written.descriptions.push_back(sensor.description);
    written.keys.push_back(key);
    for (Value::Entry& entry : sensor.description.entries) {
      if (entry.key == "effects") entry.value = sampled(entry.value, key + ".effects");
    }
    const Value* mount = sensorFields.find("mount");
    written.mounts.push_back(mount == nullptr ? Value{} : *mount);
    sensor.vehicleFromSensor = readMount(sampled(written.mounts.back(), key + ".mount"), vehicle);
    sensor.size = sensorSize(sensor.description);
    return sensors.emplace_back(std::move(sensor));
  };
  const std::vector<Value>& list = readList(fields.require("sensors"), "sensors");
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string key = fmt::format("sensors.{}", i);
    const Value* const choice = list[i].find("choice");
    if (choice == nullptr) {
      add(list[i], key);
      continue;
    }
    Value names = list[i];
    Value& items = std::ranges::find(names.entries, "choice", &Value::Entry::key)->value;
    for (std::size_t k = 0; k < items.items.size(); ++k) {
      MountedSensor& sensor = add(choice->items[k], fmt::format("{}.choice.{}", key, k));
      sensor.choice = key;
      sensor.alternatives = items.items.size();
      items.items[k] = scalarValue(sensor.name);
    }
    withDraws(names, key, {.seed = seed}, ignored);  // checks the distribution
    written.choices.emplace(key, std::move(names));
  }
  if (sensors.size() > kMostSensors) throw InputError(fields.where(), "a vehicle can have at most 4095 sensors");
  return sensors;
}

// Reads `vehicle`: the name of a scene, or a map with the keys `scene` and `returns`.
void readVehicle(Fields& fields, Pipeline& pipeline) {
  const Value* vehicle = fields.find("vehicle");
  if (vehicle == nullptr || vehicle->kind != Value::Kind::Map) {
    pipeline.vehicle = fields.optionalResource("vehicle", "scenes").value_or("");
    return;
  }
  Fields keys(*vehicle, "vehicle");
  keys.also({"scene", "returns"}).finish();
  pipeline.vehicle = keys.resource("scene", "scenes");
  pipeline.dropVehicle = keys.choice("returns", {"keep", "drop"}, "keep") == "drop";
}

// Throws InputError if the frames have more rays than Pipeline::maxRays. `perFrame`: rays per frame; `unit`: what the
// message calls these rays. `atLeast`: "at least " if there may be more frames, otherwise empty.
void checkRays(const Pipeline& pipeline, std::uint64_t frameCount, double perFrame, std::string_view unit,
               std::string_view atLeast = "") {
  const double rays = static_cast<double>(frameCount) * perFrame;
  if (rays <= pipeline.maxRays) return;
  throw InputError({pipeline.file.string()},
                   "{}{} frames x {:.0f} {} = {:.3g} rays, more than limits.max_rays = {:.3g}; at 20 million rays a "
                   "second that is {:.1f} hours. Take fewer frames, rings or columns, or raise the limit",
                   atLeast, frameCount, perFrame, unit, rays, pipeline.maxRays, rays / kTypicalRaysPerSecond / 3600);
}

// Returns the entries of the key `about`, for Pipeline::about; none if `value` is null.
std::map<std::string, std::string> readAbout(const Value* value) {
  std::map<std::string, std::string> about;
  if (value == nullptr) return about;
  Fields fields(*value, "about");
  fields.also({"description", "license", "creator", "url", "citation"}).finish();
  for (const Value::Entry& entry : value->entries) {
    if (fields.has(entry.key)) about.emplace(entry.key, fields.text(entry.key));
  }
  return about;
}

// Sets the splits of the sequences. `splitting`: the pipeline's key `splits`; null if the pipeline does not have it.
void setSplits(const Value* splitting, Pipeline& pipeline) {
  std::vector<SequenceName> names;
  for (const Sequence& s : pipeline.sequences) names.push_back({s.scene, s.sceneSeed, s.trajectoryName});
  const std::vector<std::string> splits = assignSplits(splitting, names, pipeline.seed);
  const Value* key = splitting == nullptr ? nullptr : splitting->find("by");
  pipeline.splitsBySeed = splitting != nullptr && (key == nullptr || key->text == "seed");
  for (std::size_t i = 0; i < splits.size(); ++i) pipeline.sequences[i].split = splits[i];
}

// Sets MountedSensor::period of each sensor, and Pipeline::periods: a sample has all sectors of a turn.
void readPeriods(Pipeline& pipeline) {
  pipeline.periods = {std::numeric_limits<double>::infinity(), 0};
  for (MountedSensor& sensor : pipeline.sensors) {
    sensor.period = sensor.size.period;
    pipeline.periods.shortest = std::min(pipeline.periods.shortest, sensor.period);
    pipeline.periods.longest = std::max(pipeline.periods.longest, sensor.period * sensor.size.sectors);
  }
}

// Throws InputError unless each frame of the sequence begins with a whole turn of the sensor, as its sectors need.
void checkSectors(const MountedSensor& sensor, const Sequence& sequence) {
  if (sensor.size.sectors == 1 || sequence.trajectory == nullptr) return;
  const Trajectory& path = *sequence.trajectory;
  const double turns = path.interval() / (sensor.period * sensor.size.sectors);
  const bool equal = path.still() || path.regular() || path.frames() == 1;
  if (equal && std::abs(turns - std::round(turns)) < 1e-6) return;
  throw InputError(sensor.description.where,
                   "'{}' makes its turn of {:g} s in {} sectors, but the frames of '{}' do not begin with its turns: "
                   "leave out `every_s` and `every_m`, or give a multiple of the turn as `every_s`",
                   sensor.name, sensor.period * sensor.size.sectors, sensor.size.sectors, path.name());
}

// Sets each sensor's greatest number of revolutions in a sample. A sample of a recording has one revolution of each
// sensor, whatever its rate; all periods are then set to the longest.
void countRevolutions(Pipeline& pipeline) {
  if (pipeline.recording != nullptr) {
    for (MountedSensor& sensor : pipeline.sensors) sensor.period = pipeline.periods.longest;
    pipeline.periods.shortest = pipeline.periods.longest;
    return;
  }
  for (MountedSensor& sensor : pipeline.sensors) {
    for (const Sequence& sequence : pipeline.sequences) {
      checkSectors(sensor, sequence);
      const std::uint32_t revolutions = sequence.mostRevolutions(sensor.period, pipeline.periods);
      if (revolutions > Shot::kMostRevolutions) {
        throw InputError(sensor.description.where,
                         "a sample would hold {} revolutions of the sensor '{}', which turns in {:g} s, "
                         "beside one of the slowest sensor, which takes {:g} s; at most {} are possible: "
                         "scan with these sensors in two pipelines",
                         revolutions, sensor.name, sensor.period, pipeline.periods.longest, Shot::kMostRevolutions);
      }
      sensor.revolutions = std::max(sensor.revolutions, revolutions);
    }
  }
}

// Reads the key `method`, which is required unless the pipeline has a recording.
void readMethod(Fields& fields, Pipeline& pipeline) {
  if (pipeline.recording != nullptr && fields.find("method") == nullptr) return;
  const NamedOptions method = readNamed(fields.require("method"), "method");
  if (method.name == "auto") {
    throw InputError(method.where,
                     "`method: auto` is no longer chosen by measuring, since ray_tracing is the fastest of the exact "
                     "settings everywhere (docs/tradeoff.md): write `method: ray_tracing`");
  }
  const MethodEntry& entry = requireMethod(method.name, method.where);
  // Refuses unknown keys now; the method checks the values of its keys when it is made, after the scene is read.
  Fields(method.options, "method " + method.name).alsoDescribed(entry.keys).finish();
  pipeline.method = {&entry, method.options};
}

// Returns the pipeline of a parsed text. Later keys depend on earlier keys: sequences on the sensors' periods, effects
// on sequences, sensors and ontology, and random sensors on all of these.
Pipeline pipelineOf(Value parsed, std::string text, const std::filesystem::path& file,
                    std::shared_ptr<const Recording> recording) {
  const FilesRead filesRead;
  Pipeline pipeline;
  pipeline.root = std::move(parsed);
  const Value& root = pipeline.root;
  pipeline.recording = std::move(recording);
  pipeline.file = file;
  pipeline.text = std::move(text);
  expectKind(root, FileKind::Pipeline);
  Fields fields(root, "pipeline");
  fields
      .also({"name", "seed", "labels", "wavelength_nm", "scenes", "trajectories", "sensors", "vehicle", "motion",
             "method", "effects", "corruption", "splits", "output", "limits", "tradeoff", "repeatability", "about"})
      .finish();
  pipeline.name = fields.text("name", file.stem().string());
  pipeline.seed = static_cast<std::uint64_t>(fields.integer("seed", 0, std::int64_t{1} << 62, 1));
  pipeline.ontology = fields.optionalResource("labels", "labels").value_or("");
  pipeline.about = readAbout(fields.find("about"));
  readVehicle(fields, pipeline);
  pipeline.wavelengthNm = std::stoi(fields.choice("wavelength_nm", {"850", "905", "1064", "1550"}, "905"));
  DrawnSensors::Written written;
  pipeline.sensors = readSensors(fields, pipeline.seed, pipeline.vehicle, written);
  readPeriods(pipeline);
  pipeline.maxRays = kDefaultMaxRays;
  const Value* const limits = fields.find("limits");
  if (limits != nullptr) {
    pipeline.maxRays = Fields(*limits, "limits").number("max_rays", {1, 1e18}, kDefaultMaxRays);
  }
  if (pipeline.recording != nullptr) {
    takeRecordedMounts(pipeline, *pipeline.recording, fields.require("sensors"));
    pipeline.sequences = recordedSequences(*pipeline.recording, fields);
  } else {
    const auto beams = static_cast<double>(pipeline.beamsPerFrame());
    pipeline.sequences = readSequences(fields, pipeline.periods.longest, [&](std::uint64_t frames) {
      checkRays(pipeline, frames, beams, "beams", "at least ");
    });
  }
  countRevolutions(pipeline);
  pipeline.motion = readMotion(fields.find("motion"));
  readMethod(fields, pipeline);
  written.effects = writtenEffects(root);
  readEffects(written.effects, pipeline);
  pipeline.output = readOutput(fields.require("output"));
  setSplits(fields.find("splits"), pipeline);
  if (DrawnSensors::draws(written)) pipeline.drawn = std::make_shared<const DrawnSensors>(std::move(written), pipeline);
  if (limits != nullptr) Fields(*limits, "limits").also({"max_rays"}).finish();
  checkRays(pipeline, pipeline.frames(), pipeline.rays() / static_cast<double>(pipeline.frames()),
            pipeline.raysPerFrame() == pipeline.beamsPerFrame() ? "beams" : "rays");
  pipeline.files = recordsOf(filesRead, file.parent_path());
  return pipeline;
}

}  // namespace

Pose readMount(const Value& mount, const std::filesystem::path& vehicle) {
  if (mount.kind == Value::Kind::Null) return {};
  Fields fields(mount, "mount");
  Pose pose = fields.pose();
  const std::string link = fields.text("link", "");
  fields.finish();
  if (!link.empty() && vehicle.empty()) {
    throw InputError(mount.where, "the link '{}' is one of a robot: name its scene as `vehicle`", link);
  }
  if (!link.empty()) pose = readLinkPose(vehicle, link, mount.where) * pose;
  checkedPosition(pose.translation, mount.where);
  return pose;
}

bool setsIntensity(const Pipeline& pipeline) {
  // The first sensor decides: either all sensors have an intensity, or none has.
  return intensityFullScale(*pipeline.sensors.front().effects) > 0;
}

std::uint64_t Pipeline::frames() const {
  std::uint64_t count = 0;
  for (const Sequence& s : sequences) count += s.frames;
  return count;
}

std::uint64_t Pipeline::beamsPerFrame() const {
  std::uint64_t count = 0;
  for (const MountedSensor& s : sensors) count += s.beams();
  return count;
}

std::uint64_t Pipeline::raysPerFrame() const {
  std::uint64_t count = 0;
  for (std::size_t s = 0; s < sensors.size(); ++s) count += sensors[s].beams() * raysPerBeam(s);
  return count;
}

double Pipeline::rays() const {
  double count = 0;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    double revolutions = 0;
    for (const Sequence& sequence : sequences) revolutions += sequence.totalRevolutions(sensors[s].period, periods);
    count += revolutions * static_cast<double>(sensors[s].beams() * raysPerBeam(s)) /
             static_cast<double>(sensors[s].alternatives);
  }
  return count;
}

bool Pipeline::oneRevolution() const {
  return std::ranges::all_of(sensors, [&](const MountedSensor& sensor) {
    return sensor.choice.empty() && std::ranges::all_of(sequences, [&](const Sequence& sequence) {
             return sequence.mostRevolutions(sensor.period, periods) == 1 &&
                    sequence.totalRevolutions(sensor.period, periods) == sequence.frames;
           });
  });
}

std::uint32_t Pipeline::raysPerBeam(std::size_t sensor) const {
  return recording == nullptr ? scanmill::raysPerBeam(*sensors[sensor].effects) : 1;
}

const LightPaths* Pipeline::lightPaths(std::size_t sensor) const {
  return recording == nullptr ? scanmill::lightPaths(*sensors[sensor].effects) : nullptr;
}

std::vector<const Effects*> Pipeline::effectCases(std::size_t sensor) const {
  std::vector<const Effects*> cases{sensors[sensor].effects.get()};
  if (drawn == nullptr) return cases;
  for (const SensorDraw& testCase : drawn->cases()) cases.push_back(testCase.effects[sensor].get());
  return cases;
}

std::uint32_t Pipeline::mostReturns() const {
  std::uint32_t most = 1;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    for (const Effects* effects : effectCases(s)) most = std::max(most, scanmill::mostReturns(*effects));
  }
  return most;
}

std::string Pipeline::methodName() const {
  return recording != nullptr ? recording->method : std::string(method.entry->name);
}

Pipeline readPipeline(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                      std::shared_ptr<const Recording> recording) {
  std::string text = readFile(file);
  Value root = parseYaml(text, file.string());
  // If the file itself ends with comments that look like overrides, an empty comment line separates them from the real
  // overrides.
  const bool endsLikeOverrides = !overridesIn(text).empty();
  if ((endsLikeOverrides || !overrides.empty()) && !text.ends_with('\n')) text += '\n';
  if (endsLikeOverrides) text += "#\n";
  for (const std::string& assignment : overrides) {
    setValue(root, assignment);
    text += "# --set " + commented(assignment) + "\n";
  }
  return pipelineOf(std::move(root), std::move(text), file, std::move(recording));
}

Pipeline readPipelineText(const std::string& text, const std::filesystem::path& file) {
  Value root = parseYaml(text, file.string());
  for (const std::string& assignment : overridesIn(text)) setValue(root, assignment);
  return pipelineOf(std::move(root), text, file, nullptr);
}

// The overrides are comments such as "# --set scenes.0.seeds=[3]". An override of several lines takes several comment
// lines.
std::vector<std::string> overridesIn(const std::string& text) {
  constexpr std::string_view kCommentPrefix = "# ";
  constexpr std::string_view kOverridePrefix = "# --set ";
  std::vector<std::string> lines;
  for (std::size_t lineStart = 0; lineStart < text.size();) {
    const std::size_t lineEnd = std::min(text.find('\n', lineStart), text.size());
    lines.push_back(text.substr(lineStart, lineEnd - lineStart));
    lineStart = lineEnd + 1;
  }
  std::size_t firstComment = lines.size();
  while (firstComment > 0 && lines[firstComment - 1].starts_with(kCommentPrefix)) --firstComment;
  std::vector<std::string> overrides;
  for (std::size_t i = firstComment; i < lines.size(); ++i) {
    if (lines[i].starts_with(kOverridePrefix)) {
      overrides.push_back(lines[i].substr(kOverridePrefix.size()));
    } else if (!overrides.empty()) {
      overrides.back() += '\n' + lines[i].substr(kCommentPrefix.size());
    }
  }
  return overrides;
}

}  // namespace scanmill
