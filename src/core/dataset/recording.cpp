#include "dataset/recording.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <set>

#include "base/file.h"
#include "base/hash.h"
#include "dataset/json_record.h"
#include "methods/method.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

constexpr const char* kIndexName = "recording.json";
constexpr const char* kWhat = "scanmill recording";  // value of the key `what` in the index

// Returns the numbers of a pose in a recording: w, x, y and z of the rotation, then x, y and z of the position.
std::vector<double> numbersOf(const Pose& pose) {
  const Quat& q = pose.rotation;
  const Vec3d& t = pose.translation;
  return {q.w, q.x, q.y, q.z, t.x, t.y, t.z};
}

// Reads the numbers that numbersOf() returns. Throws InputError unless the quaternion is a unit one.
Pose poseOfNumbers(const JsonNode& node) {
  const std::vector<double> n = node.numbers(7);
  const double squaredNorm = n[0] * n[0] + n[1] * n[1] + n[2] * n[2] + n[3] * n[3];
  if (!(std::abs(squaredNorm - 1) < 1e-6))
    node.fail(
        "must be a unit quaternion w, x, y, z and then the position x, y, z, but the quaternion has another length");
  return {{n[0], n[1], n[2], n[3]}, {n[4], n[5], n[6]}};
}

// Reads the name of a file, which must be directly in the recording's folder: other paths are refused, because the JSON
// may come from an untrusted source.
std::string fileNameOf(const JsonNode& node) {
  std::string name = node.text();
  if (name.empty() || fs::path(name).filename() != name || name == "." || name == "..") {
    node.fail("'{}' must be the name of a file in this folder", name);
  }
  return name;
}

// Returns true if this program may have written a file with this name for the recording: "recording.json", a temporary
// file, or a name such as "street-s1-lane-000012.top.json" with a sequence and a sensor of the recording.
bool isFileOf(const Recording& recording, const std::string& name) {
  if (name == kIndexName || name.find(".partial-") != std::string::npos) return true;
  if (!name.ends_with(".exr") && !name.ends_with(".json")) return false;
  const std::size_t dot = name.find('.');
  const std::string key = name.substr(0, dot);
  const bool hasSequence = std::ranges::any_of(recording.sequences, [&](const RecordedSequence& s) {
    return key.starts_with(fmt::format("{}-s{}-", s.scene, s.seed));
  });
  return hasSequence && std::ranges::any_of(recording.sensors, [&](const RecordedSensor& s) {
           return name.compare(dot + 1, s.name.size() + 1, s.name + ".") == 0;
         });
}

// Removes the files of an earlier finished recording by this program. Throws InputError if the folder has no such
// recording, or if it has other files, such as images with similar names that a user has rendered.
void removeEarlier(const fs::path& folder) {
  const std::optional<RecordingKind> kind = recordingIn(folder);
  if (!kind) {
    throw InputError({folder.string()},
                     "has files but no finished recording: --overwrite replaces only recordings; remove the files by "
                     "hand, or choose another folder");
  }
  const Recording earlier = readRecording(folder, *kind);
  if (earlier.programVersion.empty()) {
    throw InputError({folder.string()}, "has a recording that another program made: choose another folder");
  }
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (!entry.is_regular_file() || !isFileOf(earlier, entry.path().filename().string())) {
      throw InputError({entry.path().string()},
                       "does not belong to the recording in this folder: --overwrite replaces only recordings; choose "
                       "another folder");
    }
    files.push_back(entry.path());
  }
  fs::remove(folder /
             kIndexName);  // remove the index first, so that the other files never look like a finished recording
  for (const fs::path& file : files) fs::remove(file);
}

// Creates the folder if it does not exist. If it has files, calls removeEarlier() if `overwrite` is true, and otherwise
// throws InputError. Also throws InputError if the folder cannot be created or read.
void prepareFolder(const fs::path& folder, bool overwrite) {
  try {
    if (fs::exists(folder) && !fs::is_directory(folder)) {
      throw InputError({folder.string()}, "is a file: choose another folder");
    }
    fs::create_directories(folder);
    if (fs::is_empty(folder)) return;
    if (!overwrite) {
      throw InputError({folder.string()},
                       "exists and is not empty: add --overwrite to replace the recording in it, or choose another "
                       "folder");
    }
    removeEarlier(folder);
  } catch (const fs::filesystem_error& error) {
    throw InputError({folder.string()}, "cannot be used as the folder of a recording: " + error.code().message());
  }
}

}  // namespace

static void describe(RecordKeys& keys, RecordedSensor& sensor) {
  keys("name", sensor.name);
  keys("rings", sensor.rings, wholeNumber(1, 65536));
  keys("columns", sensor.columns, wholeNumber(1, 65536));
  keys.optional("beams", sensor.beams, kSha256Digits);
  std::optional<Pose>& mount = sensor.vehicleFromSensor;
  std::vector<double> numbers = numbersOf(mount.value_or(Pose{}));
  keys.optionalIf(mount.has_value(), "vehicle_from_sensor", numbers,
                  [&](const JsonNode& node) { mount = poseOfNumbers(node); });
}

static void describe(RecordKeys& keys, RecordedSequence& s) {
  keys("scene", s.scene, [&](const JsonNode& node) {
    if (!s.scene.empty() && s.scene.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-_") == std::string::npos) {
      return;
    }
    node.fail("'{}' becomes part of file names: use lower-case letters, digits, '-' and '_'", s.scene);
  });
  keys.mayBeMissing("seed", s.seed);
  keys("trajectory", s.trajectory, [&](const JsonNode& node) {
    if (s.trajectory.empty()) node.fail("becomes part of file names, so it must not be empty");
  });
  keys("frames", s.frames, wholeNumber(1, 10'000'000));
  keys.mayBeMissing("materials", s.materials);
  keys.optional("without", s.without);
}

static void describe(RecordKeys& keys, Material& material) {
  keys("name", material.name);
  keys("roughness", material.roughness, within(0, 1));
  keys("metallic", material.metallic, within(0, 1));
  keys("retroreflectance", material.retroreflectance, within(0, 1e9));
}

static void describe(RecordKeys& keys, Recording& r) {
  std::uint32_t version = Recording::kSchemaVersion;
  keys.fixed("what", kWhat);
  keys("schema_version", version, wholeNumber(1), [&](const JsonNode& node) {
    if (version <= Recording::kSchemaVersion) return;
    node.fail("{} is newer than this program, which reads up to {}: update scanmill", version,
              Recording::kSchemaVersion);
  });
  keys.mayBeMissing("program", r.programVersion);
  keys.custom(
      "kind", [&] { return OrderedJson(nameOf(r.kind)); },
      [&](const JsonNode& node) {
        const std::string kind = node.text();
        if (kind == nameOf(r.kind)) return;
        if (kind != "hits" && kind != "passes") node.fail("'{}' is neither hits nor passes", kind);
        node.fail("is a recording of {0}: read it with --from-{0}", kind);
      });
  keys.mayBeMissing("method", r.method);
  keys.mayBeMissing("ontology", r.ontology);
  keys("sensors", r.sensors, distinct("name"));
  keys("sequences", r.sequences, [&](const JsonNode& node) {
    std::set<std::string> names;
    for (std::size_t i = 0; i < r.sequences.size(); ++i) {
      const RecordedSequence& s = r.sequences[i];
      const std::string name = fmt::format("{} {} {}", s.scene, s.seed, s.trajectory);
      if (!names.insert(name).second) node.item(i).fail("is listed twice");
    }
    if (names.empty()) node.fail("is empty: nothing was recorded");
  });
  keys.mayBeMissing("materials", r.materials);
  keys.mayBeMissing("modelled", r.modelled);
}

// Describes a step. Other programs may leave out world_from_rig: the step then gets the first pose of its shot.
static void describe(RecordKeys& keys, RecordedStep& step) {
  std::vector<std::uint32_t> columns{step.firstColumn, step.endColumn};
  keys("columns", columns, numberCount(2), [&](const JsonNode& node) {
    step.firstColumn = node.item(0).integer<std::uint32_t>(0, 65535);
    step.endColumn = node.item(1).integer<std::uint32_t>(step.firstColumn + 1, 65536);
  });
  std::vector<double> rig = numbersOf(step.worldFromRig);
  keys.mayBeMissing("world_from_rig", rig, [&](const JsonNode& node) { step.worldFromRig = poseOfNumbers(node); });
  keys("images", step.images, [&](const JsonNode& images) {
    images.forEach([](const JsonNode& image) { fileNameOf(image); });
    if (step.images.empty()) images.fail("names no file");
  });
}

// Describes the file of a shot. Recording::shot() requires `hits` or `steps`, depending on the kind of the recording.
static void describe(RecordKeys& keys, RecordedShot& shot) {
  keys.optional("sample", shot.sample);
  keys.optional("sensor", shot.sensor);
  keys("time", shot.time);
  std::vector<std::vector<double>> poses;
  for (const Pose& pose : shot.worldFromSensor) poses.push_back(numbersOf(pose));
  keys("world_from_sensor", poses, [&](const JsonNode& node) {
    node.forEach([&](const JsonNode& pose) { shot.worldFromSensor.push_back(poseOfNumbers(pose)); });
    if (shot.worldFromSensor.empty()) node.fail("has no pose");
  });
  keys.optional("hits", shot.hits, [](const JsonNode& node) { fileNameOf(node); });
  keys.optionalIf(!shot.steps.empty(), "steps", shot.steps, [&](const JsonNode& steps) {
    std::uint32_t nextColumn = 0;
    for (std::size_t i = 0; i < shot.steps.size(); ++i) {
      if (shot.steps[i].firstColumn != nextColumn) {
        steps.item(i)["columns"].fail("must be [first, end] with first = {}, since steps must have consecutive columns",
                                      nextColumn);
      }
      nextColumn = shot.steps[i].endColumn;
      if (!steps.item(i).has("world_from_rig")) shot.steps[i].worldFromRig = shot.worldFromSensor.front();
    }
  });
}

std::string beamsHash(const BeamTable& beams) {
  Sha256 hash;
  const auto addBytesOf = [&](const auto& values) {
    hash.add({reinterpret_cast<const char*>(std::data(values)), std::size(values) * sizeof *std::data(values)});
  };
  addBytesOf(beams.direction);
  addBytesOf(beams.origin);
  addBytesOf(std::array{beams.minRange, beams.maxRange});
  return hash.hex();
}

std::string_view nameOf(RecordingKind kind) {
  return kind == RecordingKind::Hits ? "hits" : "passes";
}

Recording readRecording(const fs::path& folder, RecordingKind kind) {
  const fs::path file = folder / kIndexName;
  if (isFolder(folder) && !pathExists(file)) {
    throw InputError({folder.string()},
                     "has no recording.json: it is not a recording, or the run that wrote it did not end; make one by "
                     "scanmill generate --keep-hits or scanmill render");
  }
  const Json json = parseJson(readFile(file), file.string());
  const std::string name = file.string();
  const JsonNode root(json, "", name);
  if (!json.is_object() || json.value("what", Json()) != kWhat) {
    throw InputError({name}, "is not a recording: /what must be '{}'", kWhat);
  }
  Recording r{.kind = kind, .folder = folder};
  // A recording by another program contains passes. If it has no key `method`, the first method for passes is used.
  r.method = firstMethodThat(&MethodCapabilities::passes).name;
  readJson(root, r);
  const std::size_t tables = r.materials.size();
  if (r.materials.empty()) r.materials.emplace_back();  // sequences without the key `materials` refer to table 0
  for (std::size_t i = 0; i < r.sequences.size(); ++i) {
    if (r.sequences[i].materials < r.materials.size()) continue;
    root["sequences"].item(i)["materials"].fail("is out of range: the recording has {} tables of materials", tables);
  }
  return r;
}

std::optional<RecordingKind> recordingIn(const fs::path& folder) {
  const fs::path file = folder / kIndexName;
  if (!pathExists(file)) return std::nullopt;
  const Json json = parseJson(readFile(file), file.string());
  const Json kind = json.is_object() ? json.value("kind", Json()) : Json();
  return kind == nameOf(RecordingKind::Hits) ? RecordingKind::Hits : RecordingKind::Passes;
}

RecordedShot Recording::shot(const std::string& sample, const std::string& sensor) const {
  const std::string file = (folder / fmt::format("{}.{}.json", sample, sensor)).string();
  const Json json = parseJson(readFile(file), file);
  const JsonNode root(json, "", file);
  RecordedShot shot;
  readJson(root, shot);
  shot.sample = sample;
  shot.sensor = sensor;
  const char* const requiredKey = kind == RecordingKind::Passes ? "steps" : "hits";
  if (!root.has(requiredKey)) root.fail("key '{}' is missing", requiredKey);
  const auto recorded = std::ranges::find(sensors, sensor, &RecordedSensor::name);
  const std::uint32_t endColumn = shot.steps.empty() ? 0 : shot.steps.back().endColumn;
  if (kind == RecordingKind::Passes && recorded != sensors.end() && endColumn != recorded->columns) {
    root["steps"].fail("end at column {}, but '{}' has {} columns", endColumn, sensor, recorded->columns);
  }
  return shot;
}

RecordingWriter::RecordingWriter(fs::path folder, bool overwrite) : folder_(std::move(folder)) {
  prepareFolder(folder_, overwrite);
}

fs::path RecordingWriter::file(std::string_view sample, std::string_view sensor, std::string_view ending) const {
  return folder_ / fmt::format("{}.{}.{}", sample, sensor, ending);
}

void RecordingWriter::add(const RecordedShot& shot) {
  writeFile(file(shot.sample, shot.sensor, "json"), layOut(jsonOf(shot, shot.sample)) + "\n");
}

void RecordingWriter::finish(const Recording& recording) {
  writeFile(folder_ / kIndexName, layOut(jsonOf(recording, "recording")) + "\n");
}

}  // namespace scanmill
