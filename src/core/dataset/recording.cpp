#include "dataset/recording.h"

#include <fmt/core.h>

#include <algorithm>
#include <set>

#include "base/file.h"
#include "base/hash.h"
#include "dataset/json_node.h"
#include "dataset/json_text.h"
#include "methods/method.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

constexpr const char* kIndex = "recording.json";
constexpr const char* kWhat = "scanmill recording";

std::string shotName(std::string_view sample, std::string_view sensor) {
  return fmt::format("{}.{}", sample, sensor);
}

OrderedJson posesJson(const std::vector<Pose>& poses, const std::string& what) {
  OrderedJson list = OrderedJson::array();
  for (const Pose& p : poses) {
    const Quat& q = p.rotation;
    const Vec3d& t = p.translation;
    list.push_back(finiteList({q.w, q.x, q.y, q.z, t.x, t.y, t.z}, what));
  }
  return list;
}

Pose poseOfNumbers(const JsonNode& node) {
  const std::vector<double> n = node.numbers(7);
  const double norm = n[0] * n[0] + n[1] * n[1] + n[2] * n[2] + n[3] * n[3];
  if (!(std::abs(norm - 1) < 1e-6))
    node.fail(
        "must be a unit quaternion w, x, y, z and then the position x, y, z, but the quaternion has another length");
  return {{n[0], n[1], n[2], n[3]}, {n[4], n[5], n[6]}};
}

std::string shotJson(const RecordedShot& shot) {
  OrderedJson json{{"sample", shot.sample},
                   {"sensor", shot.sensor},
                   {"time", finite(shot.time, "time")},
                   {"world_from_sensor", posesJson(shot.worldFromSensor, shot.sample)}};
  if (!shot.hits.empty()) json["hits"] = shot.hits;
  if (!shot.steps.empty()) {
    OrderedJson steps = OrderedJson::array();
    for (const RecordedStep& s : shot.steps) {
      steps.push_back({{"columns", {s.firstColumn, s.endColumn}},
                       {"world_from_rig", posesJson({s.worldFromRig}, shot.sample)[0]},
                       {"images", s.images}});
    }
    json["steps"] = std::move(steps);
  }
  return layOut(json) + "\n";
}

std::string indexJson(const Recording& r) {
  OrderedJson sensors = OrderedJson::array();
  for (const RecordedSensor& s : r.sensors) {
    OrderedJson sensor{{"name", s.name}, {"rings", s.rings}, {"columns", s.columns}};
    if (!s.beams.empty()) sensor["beams"] = s.beams;
    if (s.vehicleFromSensor) sensor["vehicle_from_sensor"] = posesJson({*s.vehicleFromSensor}, s.name)[0];
    sensors.push_back(std::move(sensor));
  }
  OrderedJson sequences = OrderedJson::array();
  for (const RecordedSequence& s : r.sequences) {
    sequences.push_back({{"scene", s.scene},
                         {"seed", s.seed},
                         {"trajectory", s.trajectory},
                         {"frames", s.frames},
                         {"materials", s.materials}});
    if (!s.without.empty()) sequences.back()["without"] = s.without;
  }
  OrderedJson tables = OrderedJson::array();
  for (const std::vector<Material>& table : r.materials) {
    OrderedJson list = OrderedJson::array();
    for (const Material& m : table) {
      list.push_back({{"name", m.name},
                      {"roughness", finite(double{m.roughness}, m.name)},
                      {"metallic", finite(double{m.metallic}, m.name)},
                      {"retroreflectance", finite(double{m.retroreflectance}, m.name)}});
    }
    tables.push_back(std::move(list));
  }
  const OrderedJson json{{"what", kWhat},
                         {"schema_version", Recording::kSchemaVersion},
                         {"program", r.programVersion},
                         {"kind", nameOf(r.kind)},
                         {"method", r.method},
                         {"ontology", ontologyJson(r.ontology)},
                         {"sensors", std::move(sensors)},
                         {"sequences", std::move(sequences)},
                         {"materials", std::move(tables)},
                         {"modelled", modelledJson(r.modelled)}};
  return layOut(json) + "\n";
}

Material materialOf(const JsonNode& node) {
  node.keys({"name", "roughness", "metallic", "retroreflectance"});
  Material material;
  material.name = node["name"].text();
  material.roughness = static_cast<float>(node["roughness"].number(0, 1));
  material.metallic = static_cast<float>(node["metallic"].number(0, 1));
  material.retroreflectance = static_cast<float>(node["retroreflectance"].number(0, 1e9));
  return material;
}

// Reads the name of a file, which must be directly in the recording's folder: other paths are refused, because the JSON
// may come from an untrusted source.
std::string fileOf(const JsonNode& node) {
  std::string name = node.text();
  if (name.empty() || fs::path(name).filename() != name || name == "." || name == "..") {
    node.fail(fmt::format("'{}' must be the name of a file in this folder", name));
  }
  return name;
}

RecordedSequence sequenceOf(const JsonNode& node, std::size_t tables) {
  node.keys({"scene", "trajectory", "frames"}, {"seed", "materials", "without"});
  RecordedSequence s;
  s.scene = node["scene"].text();
  s.trajectory = node["trajectory"].text();
  if (s.scene.empty() || s.scene.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-_") != std::string::npos) {
    node["scene"].fail(
        fmt::format("'{}' becomes part of file names: use lower-case letters, digits, '-' and '_'", s.scene));
  }
  if (s.trajectory.empty()) node["trajectory"].fail("becomes part of file names, so it must not be empty");
  s.frames = node["frames"].integer<std::uint32_t>(1, 10'000'000);
  if (node.has("seed")) s.seed = node["seed"].integer<std::uint64_t>();
  if (node.has("materials")) s.materials = node["materials"].integer<std::uint32_t>();
  if (node.has("without")) {
    node["without"].forEach([&](const JsonNode& item) { s.without.push_back(item.text()); });
  }
  if (s.materials >= std::max<std::size_t>(tables, 1))
    node["materials"].fail(fmt::format("is out of range: the recording has {} tables of materials", tables));
  return s;
}

// Returns true if a file has the name of a file that this program writes for the recording `earlier`, such as
// "street-s1-lane-000012.top.json" for its sequences and sensors.
bool isOurs(const std::string& name, const Recording& earlier) {
  if (name == kIndex || name.find(".partial-") != std::string::npos) return true;
  if (!name.ends_with(".exr") && !name.ends_with(".json")) return false;
  const std::size_t dot = name.find('.');
  const std::string key = name.substr(0, dot);
  const bool sequence = std::any_of(earlier.sequences.begin(), earlier.sequences.end(), [&](const auto& s) {
    return key.starts_with(fmt::format("{}-s{}-", s.scene, s.seed));
  });
  return sequence && std::any_of(earlier.sensors.begin(), earlier.sensors.end(), [&](const RecordedSensor& s) {
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
  std::vector<fs::path> old;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (!entry.is_regular_file() || !isOurs(entry.path().filename().string(), earlier)) {
      throw InputError({entry.path().string()},
                       "does not belong to the recording in this folder: --overwrite replaces only recordings; choose "
                       "another folder");
    }
    old.push_back(entry.path());
  }
  fs::remove(folder / kIndex);  // remove the index first, so that the other files never look like a finished recording
  for (const fs::path& file : old) fs::remove(file);
}

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

std::string beamsHash(const BeamTable& beams) {
  Sha256 hash;
  const auto add = [&](const auto* values, std::size_t count) {
    hash.add({reinterpret_cast<const char*>(values), count * sizeof *values});
  };
  add(beams.direction.data(), beams.direction.size());
  add(beams.origin.data(), beams.origin.size());
  const double limits[] = {beams.minRange, beams.maxRange};
  add(limits, 2);
  return hash.hex();
}

std::string_view nameOf(RecordingKind kind) {
  return kind == RecordingKind::Hits ? "hits" : "passes";
}

Recording readRecording(const fs::path& folder, RecordingKind kind) {
  const fs::path file = folder / kIndex;
  std::error_code ignored;
  if (fs::is_directory(folder, ignored) && !fs::exists(file, ignored)) {
    throw InputError({folder.string()},
                     "has no recording.json: it is not a recording, or the run that wrote it did not end; make one by "
                     "scanmill generate --keep-hits or --keep-passes");
  }
  const Json json = parseJson(readFile(file), file.string());
  const std::string name = file.string();
  const JsonNode root(json, "", name);
  if (!json.is_object() || json.value("what", Json()) != kWhat) {
    throw InputError({name}, fmt::format("is not a recording: /what must be '{}'", kWhat));
  }
  root.keys({"what", "schema_version", "kind", "sensors", "sequences"},
            {"program", "method", "ontology", "materials", "modelled"});
  if (const auto version = root["schema_version"].integer<std::uint32_t>(1); version > Recording::kSchemaVersion) {
    root["schema_version"].fail(fmt::format("{} is newer than this program, which reads up to {}: update scanmill",
                                            version, Recording::kSchemaVersion));
  }
  Recording r;
  r.kind = kind;
  r.folder = folder;
  if (const std::string found = root["kind"].text(); found != nameOf(kind)) {
    if (found != "hits" && found != "passes") root["kind"].fail(fmt::format("'{}' is neither hits nor passes", found));
    root["kind"].fail(fmt::format("is a recording of {}: read it with --from-{}", found, found));
  }
  if (root.has("program")) r.programVersion = root["program"].text();
  // Recordings by other programs contain passes, and do not have to name a method.
  r.method =
      root.has("method") ? root["method"].text() : std::string(firstMethodThat(&MethodCapabilities::passes).name);
  if (root.has("ontology")) r.ontology = ontologyOf(root["ontology"]);
  if (root.has("modelled")) r.modelled = modelledOf(root["modelled"], true);
  if (root.has("materials")) {
    root["materials"].forEach([&](const JsonNode& list) {
      r.materials.emplace_back();
      list.forEach([&](const JsonNode& item) { r.materials.back().push_back(materialOf(item)); });
    });
  }
  const std::size_t tables = r.materials.size();
  if (r.materials.empty()) r.materials.emplace_back();
  root["sensors"].forEach([&](const JsonNode& item) {
    item.keys({"name", "rings", "columns"}, {"beams", "vehicle_from_sensor"});
    RecordedSensor sensor;
    sensor.name = item["name"].text();
    for (const RecordedSensor& other : r.sensors) {
      if (other.name == sensor.name) item["name"].fail(fmt::format("two sensors are named '{}'", sensor.name));
    }
    sensor.rings = item["rings"].integer<std::uint32_t>(1, 65536);
    sensor.columns = item["columns"].integer<std::uint32_t>(1, 65536);
    if (item.has("beams")) sensor.beams = item["beams"].sha256();
    if (item.has("vehicle_from_sensor")) sensor.vehicleFromSensor = poseOfNumbers(item["vehicle_from_sensor"]);
    r.sensors.push_back(std::move(sensor));
  });
  std::set<std::string> known;
  root["sequences"].forEach([&](const JsonNode& item) {
    r.sequences.push_back(sequenceOf(item, tables));
    const RecordedSequence& s = r.sequences.back();
    if (!known.insert(fmt::format("{} {} {}", s.scene, s.seed, s.trajectory)).second) item.fail("is listed twice");
  });
  if (r.sequences.empty()) root["sequences"].fail("is empty: nothing was recorded");
  return r;
}

std::optional<RecordingKind> recordingIn(const fs::path& folder) {
  const fs::path file = folder / kIndex;
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return std::nullopt;
  const Json json = parseJson(readFile(file), file.string());
  const Json kind = json.is_object() ? json.value("kind", Json()) : Json();
  return kind == nameOf(RecordingKind::Hits) ? RecordingKind::Hits : RecordingKind::Passes;
}

RecordedShot Recording::shot(const std::string& sample, const std::string& sensor) const {
  const std::string file = (folder / (shotName(sample, sensor) + ".json")).string();
  const Json json = parseJson(readFile(file), file);
  const JsonNode root(json, "", file);
  const bool passes = kind == RecordingKind::Passes;
  root.keys({"time", "world_from_sensor", passes ? "steps" : "hits"}, {"sample", "sensor"});
  RecordedShot shot;
  shot.sample = sample;
  shot.sensor = sensor;
  shot.time = root["time"].number();
  root["world_from_sensor"].forEach([&](const JsonNode& pose) { shot.worldFromSensor.push_back(poseOfNumbers(pose)); });
  if (shot.worldFromSensor.empty()) root["world_from_sensor"].fail("has no pose");
  if (!passes) {
    shot.hits = fileOf(root["hits"]);
    return shot;
  }
  std::uint32_t next = 0;
  root["steps"].forEach([&](const JsonNode& item) {
    item.keys({"columns", "images"}, {"world_from_rig"});
    RecordedStep step;
    const std::vector<double> columns = item["columns"].numbers(2);
    step.firstColumn = static_cast<std::uint32_t>(std::clamp(columns[0], 0.0, 65536.0));
    step.endColumn = static_cast<std::uint32_t>(std::clamp(columns[1], 0.0, 65536.0));
    if (columns[0] != next || !(columns[1] > columns[0]) || step.endColumn != columns[1]) {
      item["columns"].fail(
          fmt::format("must be [first, end] with first = {}, since steps must have consecutive columns", next));
    }
    next = step.endColumn;
    step.worldFromRig =
        item.has("world_from_rig") ? poseOfNumbers(item["world_from_rig"]) : shot.worldFromSensor.front();
    item["images"].forEach([&](const JsonNode& image) { step.images.push_back(fileOf(image)); });
    if (step.images.empty()) item["images"].fail("names no file");
    shot.steps.push_back(std::move(step));
  });
  const auto known = std::find_if(sensors.begin(), sensors.end(), [&](const auto& s) { return s.name == sensor; });
  if (known != sensors.end() && next != known->columns) {
    root["steps"].fail(fmt::format("end at column {}, but '{}' has {} columns", next, sensor, known->columns));
  }
  return shot;
}

RecordingWriter::RecordingWriter(fs::path folder, bool overwrite) : folder_(std::move(folder)) {
  prepareFolder(folder_, overwrite);
}

fs::path RecordingWriter::file(std::string_view sample, std::string_view sensor, std::string_view rest) const {
  return folder_ / fmt::format("{}.{}", shotName(sample, sensor), rest);
}

void RecordingWriter::add(const RecordedShot& shot) {
  writeFile(file(shot.sample, shot.sensor, "json"), shotJson(shot));
}

void RecordingWriter::finish(const Recording& recording) {
  writeFile(folder_ / kIndex, indexJson(recording));
}

}  // namespace scanmill
