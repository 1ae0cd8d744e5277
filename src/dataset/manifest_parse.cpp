// manifest.json back to a Manifest: what is missing, of the wrong type, out of range or unknown is refused at its place
// (a JSON pointer, RFC 6901).

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "base/error.h"
#include "base/file.h"
#include "dataset/manifest.h"
#include "dataset/sample_json.h"
#include "dataset/shard_name.h"

namespace scanmill {

namespace {

using Json = nlohmann::json;

// A value with its place.
class Node {
 public:
  Node(const Json& value, std::string place, const std::string& file)
      : value_(value), place_(std::move(place)), file_(file) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError({file_}, fmt::format("{}: {}", place_.empty() ? "/" : place_, what));
  }

  // Checks a map's keys: all `required` must be there, and nothing beyond `optional`.
  const Node& keys(std::initializer_list<std::string_view> required,
                   std::initializer_list<std::string_view> optional = {}) const {
    expect(value_.is_object(), "a map");
    for (const std::string_view key : required) {
      if (!value_.contains(key)) fail(fmt::format("key '{}' is missing", key));
    }
    for (const auto& entry : value_.items()) {
      const auto is = [&](std::string_view key) { return key == entry.key(); };
      if (std::none_of(required.begin(), required.end(), is) && std::none_of(optional.begin(), optional.end(), is)) {
        fail(fmt::format("key '{}' is unknown", entry.key()));
      }
    }
    return *this;
  }

  bool has(std::string_view key) const { return value_.is_object() && value_.contains(key); }
  Node operator[](const std::string& key) const { return {value_.at(key), place_ + "/" + key, file_}; }

  template <class Visit>
  void forEach(const Visit& visit) const {
    expect(value_.is_array(), "a list");
    for (std::size_t i = 0; i < value_.size(); ++i) visit(Node(value_[i], fmt::format("{}/{}", place_, i), file_));
  }
  template <class Visit>
  void forEachEntry(const Visit& visit) const {
    expect(value_.is_object(), "a map");
    for (const auto& entry : value_.items()) visit(entry.key(), (*this)[entry.key()]);
  }

  std::string text() const {
    expect(value_.is_string(), "text");
    return value_.get<std::string>();
  }
  bool boolean() const {
    expect(value_.is_boolean(), "true or false");
    return value_.get<bool>();
  }
  double number(double low = -std::numeric_limits<double>::max(),
                double high = std::numeric_limits<double>::max()) const {
    expect(value_.is_number(), "a number");
    const double number = value_.get<double>();
    if (!(number >= low && number <= high)) fail(fmt::format("{} is not within {} to {}", number, low, high));
    return number;
  }
  template <class Integer>
  Integer integer(std::uint64_t low = 0, std::uint64_t high = std::numeric_limits<Integer>::max()) const {
    expect(value_.is_number_unsigned(), "a whole number from 0");
    const std::uint64_t number = value_.get<std::uint64_t>();
    if (number < low || number > high) fail(fmt::format("{} is not within {} to {}", number, low, high));
    return static_cast<Integer>(number);
  }
  std::string sha256() const {
    std::string hash = text();
    if (hash.size() != 64 || hash.find_first_not_of("0123456789abcdef") != std::string::npos) {
      fail("is no SHA-256 (64 hexadecimal digits in lower case)");
    }
    return hash;
  }
  std::vector<std::string> texts() const {
    std::vector<std::string> list;
    forEach([&](const Node& item) { list.push_back(item.text()); });
    return list;
  }
  std::vector<double> numbers(std::size_t count) const {
    std::vector<double> list;
    forEach([&](const Node& item) { list.push_back(item.number()); });
    if (list.size() != count) fail(fmt::format("has {} numbers where {} belong", list.size(), count));
    return list;
  }

 private:
  void expect(bool holds, std::string_view what) const {
    if (!holds) fail(fmt::format("is {} where {} belongs", value_.type_name(), what));
  }

  const Json& value_;
  std::string place_;
  const std::string& file_;
};

Pose poseOf(const Node& node) {
  node.keys({"rotation", "translation"});
  const std::vector<double> q = node["rotation"].numbers(4);
  const std::vector<double> t = node["translation"].numbers(3);
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(std::abs(norm - 1) < 1e-6)) node["rotation"].fail(fmt::format("is no unit quaternion (its norm is {})", norm));
  return {{q[0], q[1], q[2], q[3]}, {t[0], t[1], t[2]}};
}

Ontology ontologyOf(const Node& node) {
  node.keys({"name", "source", "classes"});
  Ontology ontology{node["name"].text(), node["source"].text(), {}};
  node["classes"].forEach([&](const Node& item) {
    item.keys({"id", "name", "color", "thing"}, {"aliases"});
    SemanticClass c;
    c.id = item["id"].integer<std::uint16_t>();
    c.name = item["name"].text();
    std::vector<std::uint8_t> color;
    item["color"].forEach([&](const Node& part) { color.push_back(part.integer<std::uint8_t>()); });
    if (color.size() != 3) item["color"].fail("is not [red, green, blue]");
    std::copy(color.begin(), color.end(), c.color.begin());
    c.thing = item["thing"].boolean();
    if (item.has("aliases")) c.aliases = item["aliases"].texts();
    for (const SemanticClass& other : ontology.classes) {
      if (other.id == c.id) item["id"].fail(fmt::format("{} is given to '{}' too", c.id, other.name));
      if (other.name == c.name) item["name"].fail(fmt::format("'{}' is given to class {} too", c.name, other.id));
    }
    ontology.classes.push_back(std::move(c));
  });
  return ontology;
}

SensorRecord sensorOf(const Node& node) {
  node.keys({"name", "model", "source", "vehicle_from_sensor", "rings", "columns", "period", "clockwise", "top_down",
             "min_range", "max_range", "first_azimuth", "field", "origin_offset", "origin_height", "elevation",
             "azimuth_offset", "firing_offset"});
  SensorRecord sensor;
  sensor.name = node["name"].text();
  sensor.vehicleFromSensor = poseOf(node["vehicle_from_sensor"]);
  BeamTable& b = sensor.beams;
  b.model = node["model"].text();
  b.source = node["source"].text();
  b.rings = node["rings"].integer<std::uint32_t>(1, 65536);
  b.columns = node["columns"].integer<std::uint32_t>(1, 65536);
  b.period = node["period"].number(0);
  b.clockwise = node["clockwise"].boolean();
  b.topDown = node["top_down"].boolean();
  b.minRange = node["min_range"].number(0);
  b.maxRange = node["max_range"].number(b.minRange);
  b.firstAzimuth = node["first_azimuth"].number();
  b.field = node["field"].number(0, 2 * kPi);
  b.originOffset = node["origin_offset"].number();
  b.originHeight = node["origin_height"].number();
  b.elevation = node["elevation"].numbers(b.rings);
  b.azimuthOffset = node["azimuth_offset"].numbers(b.rings);
  b.firingOffset = node["firing_offset"].numbers(b.rings);
  return sensor;
}

ScanRecord scanOf(const Node& node, const Manifest& manifest) {
  node.keys({"sensor", "method", "time", "world_from_sensor", "beams", "points", "instances", "points_per_class"});
  ScanRecord scan;
  scan.sensor = node["sensor"].text();
  if (std::none_of(manifest.sensors.begin(), manifest.sensors.end(),
                   [&](const SensorRecord& sensor) { return sensor.name == scan.sensor; })) {
    node["sensor"].fail(fmt::format("no sensor is named '{}'", scan.sensor));
  }
  scan.method = node["method"].text();
  scan.time = node["time"].number();
  node["world_from_sensor"].forEach([&](const Node& pose) { scan.worldFromSensor.push_back(poseOf(pose)); });
  if (scan.worldFromSensor.empty()) node["world_from_sensor"].fail("has no pose");
  scan.beams = node["beams"].integer<std::uint64_t>();
  scan.points = node["points"].integer<std::uint64_t>();
  scan.instances = node["instances"].integer<std::uint32_t>();
  node["points_per_class"].forEach([&](const Node& item) {
    item.keys({"id", "name", "points"});
    const std::uint16_t id = item["id"].integer<std::uint16_t>();
    const SemanticClass* known = manifest.ontology.find(id);
    if (known == nullptr) item["id"].fail(fmt::format("class {} is not in ontology '{}'", id, manifest.ontology.name));
    if (item["name"].text() != known->name) {
      item["name"].fail(fmt::format("class {} is '{}' in the ontology", id, known->name));
    }
    if (!scan.pointsPerClass.emplace(id, item["points"].integer<std::uint64_t>()).second) {
      item["id"].fail(fmt::format("class {} is counted twice", id));
    }
  });
  return scan;
}

ShardRecord shardOf(const Node& node) {
  node.keys({"file", "split", "sha256", "bytes", "samples"});
  ShardRecord shard;
  shard.file = node["file"].text();
  shard.split = node["split"].text();
  // Whoever overwrites a dataset removes the files that its manifest names: none may lie elsewhere.
  if (!isShardName(shard.file) || !shard.file.starts_with(shard.split + "/")) {
    node["file"].fail(fmt::format("'{}' is no shard of split '{}' (SPLIT/SPLIT-000000.tar)", shard.file, shard.split));
  }
  shard.sha256 = node["sha256"].sha256();
  shard.bytes = node["bytes"].integer<std::uint64_t>();
  shard.samples = node["samples"].integer<std::uint64_t>();
  return shard;
}

SampleRecord sampleOf(const Node& node, const Manifest& manifest) {
  node.keys({"key", "split", "shard", "members", "scans"});
  SampleRecord sample;
  sample.key = node["key"].text();
  if (sample.key.empty() || sample.key.find_first_of("./") != std::string::npos) {
    node["key"].fail(fmt::format("'{}' is no key (text without dots and slashes)", sample.key));
  }
  sample.split = node["split"].text();
  sample.shard = node["shard"].integer<std::uint32_t>();
  if (sample.shard >= manifest.shards.size()) {
    node["shard"].fail(fmt::format("{} is out of range: there are {} shards", sample.shard, manifest.shards.size()));
  }
  if (manifest.shards[sample.shard].split != sample.split) {
    node["split"].fail(fmt::format("is '{}' but shard {} is of '{}'", sample.split, sample.shard,
                                   manifest.shards[sample.shard].split));
  }
  node["members"].forEach([&](const Node& item) {
    std::string member = item.text();
    if (!member.starts_with(sample.key + ".")) {
      item.fail(fmt::format("'{}' does not start with the sample's key '{}'", member, sample.key));
    }
    sample.members.push_back(std::move(member));
  });
  node["scans"].forEach([&](const Node& item) { sample.scans.push_back(scanOf(item, manifest)); });
  return sample;
}

void checkVersion(const Node& root, const Json& json, const std::string& file) {
  const bool ours = json.is_object() && json.contains("schema_version") && json["schema_version"].is_number_integer() &&
                    json.contains("program") && json["program"].is_object() &&
                    json["program"].value("name", Json()) == "scanmill";
  if (!ours) throw InputError({file}, "is not a manifest of scanmill");
  const Node version = root["schema_version"];
  const std::int64_t found = json["schema_version"].get<std::int64_t>();
  if (found > Manifest::kSchemaVersion) {
    version.fail(fmt::format("{} is newer than this program, which reads up to {}: update scanmill", found,
                             Manifest::kSchemaVersion));
  }
  if (found < 1) version.fail(fmt::format("{} is no version: the first is 1", found));
}

Manifest manifestOf(const Node& root) {
  root.keys({"schema_version", "program", "name", "seed", "pipeline", "units", "frames", "scans", "formats", "ontology",
             "sensors", "modelled", "stages", "shards", "samples"});
  Manifest m;
  m.programVersion = root["program"].keys({"name", "version"})["version"].text();
  m.name = root["name"].text();
  m.seed = root["seed"].integer<std::uint64_t>();
  const Node pipeline = root["pipeline"];
  pipeline.keys({"sha256", "text"});
  m.pipelineSha256 = pipeline["sha256"].sha256();
  m.pipelineText = pipeline["text"].text();
  const Node units = root["units"];
  units.keys({"length", "time", "angle"});
  const auto unit = [&](const std::string& quantity, std::string_view expected) {
    if (units[quantity].text() != expected) units[quantity].fail(fmt::format("is not '{}'", expected));
  };
  unit("length", "metres");
  unit("time", "seconds");
  unit("angle", "radians");
  root["frames"].forEachEntry([](const std::string&, const Node& meaning) { meaning.text(); });
  const Node scans = root["scans"];
  scans.keys({"organised", "deskewed", "columns"});
  m.organised = scans["organised"].boolean();
  m.deskewed = scans["deskewed"].boolean();
  m.columns = scans["columns"].texts();
  root["formats"].forEach([&](const Node& item) {
    item.keys({"name", "suffix", "max_error"});
    m.formats.push_back({item["name"].text(), item["suffix"].text(), item["max_error"].number(0)});
  });
  m.ontology = ontologyOf(root["ontology"]);
  root["sensors"].forEach([&](const Node& item) { m.sensors.push_back(sensorOf(item)); });
  m.modelled = root["modelled"].texts();
  root["stages"].forEachEntry([&](const std::string& stage, const Node& time) { m.stages[stage] = time.number(0); });
  root["shards"].forEach([&](const Node& item) { m.shards.push_back(shardOf(item)); });
  std::set<std::string> keys;
  root["samples"].forEach([&](const Node& item) {
    m.samples.push_back(sampleOf(item, m));
    if (!keys.insert(m.samples.back().key).second) item["key"].fail("another sample has this key");
  });
  return m;
}

Location placeOfByte(const std::string& text, std::size_t byte, const std::string& file) {
  const std::string_view before = std::string_view(text).substr(0, byte == 0 ? 0 : std::min(byte - 1, text.size()));
  const std::size_t lineStart = before.rfind('\n') + 1;  // npos + 1 is 0
  return {file, static_cast<int>(std::count(before.begin(), before.end(), '\n')) + 1,
          static_cast<int>(before.size() - lineStart) + 1};
}

Json parseText(const std::string& text, const std::string& file) {
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& error) {
    // "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error while ..."
    const std::string_view what = error.what();
    const std::size_t colon = what.find(": ");
    throw InputError(
        placeOfByte(text, error.byte, file),
        fmt::format("is no whole JSON: {}", colon == std::string_view::npos ? what : what.substr(colon + 2)));
  } catch (const Json::exception& error) {
    throw InputError({file}, fmt::format("is no valid JSON: {}", error.what()));
  }
}

}  // namespace

Manifest parseManifest(const std::string& text, const std::string& file) {
  const Json json = parseText(text, file);
  const Node root(json, "", file);
  checkVersion(root, json, file);
  return manifestOf(root);
}

Manifest readManifest(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / kManifestName;
  std::error_code ignored;
  if (std::filesystem::is_directory(folder, ignored) && !std::filesystem::exists(file, ignored)) {
    throw InputError({folder.string()},
                     "has no manifest.json: it is no dataset, or the run that wrote it did not end; generate it again "
                     "with --overwrite");
  }
  return parseManifest(readFile(file), file.string());
}

}  // namespace scanmill
