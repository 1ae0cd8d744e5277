// Parses manifest.json. Keys that are missing or unknown, and values that have the wrong type or are out of range, are
// refused with their place (a JSON pointer, RFC 6901).

#include <fmt/core.h>

#include <algorithm>
#include <set>
#include <string_view>

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/terminal.h"
#include "dataset/json_node.h"
#include "dataset/manifest.h"
#include "dataset/shard_name.h"

namespace scanmill {

namespace {

std::shared_ptr<const ListedBeams> listedOf(const JsonNode& node, std::size_t beams) {
  node.keys({"azimuth", "elevation", "time"}, {"origin"});
  auto listed = std::make_shared<ListedBeams>();
  listed->azimuth = node["azimuth"].numbers(beams);
  listed->elevation = node["elevation"].numbers(beams);
  listed->time = node["time"].numbers(beams);
  if (!node.has("origin")) return listed;
  const std::vector<double> origin = node["origin"].numbers(3 * beams);
  for (std::size_t i = 0; i < origin.size(); i += 3) {
    listed->origin.push_back(static_cast<Vec3f>(Vec3d{origin[i], origin[i + 1], origin[i + 2]}));
  }
  return listed;
}

SensorRecord sensorOf(const JsonNode& node) {
  node.keys(
      {"name", "model", "source", "rings", "columns", "period", "clockwise", "top_down", "min_range", "max_range",
       "first_azimuth", "field", "origin_offset", "origin_height", "elevation", "azimuth_offset", "firing_offset"},
      {"vehicle_from_sensor", "origin_left", "origin_up", "beams", "rosette", "sweep", "intensity_full_scale"});
  SensorRecord sensor;
  sensor.name = node["name"].text();
  if (sensor.name != oneLine(sensor.name)) node["name"].fail("has control characters");
  if (node.has("vehicle_from_sensor")) sensor.vehicleFromSensor = poseOf(node["vehicle_from_sensor"]);
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
  if (node.has("beams")) b.listed = listedOf(node["beams"], b.size());
  if (node.has("rosette")) {
    const JsonNode own = node["rosette"];
    own.keys({"angle", "speed", "phase"}, {"left", "up", "mirror"});
    b.rosette.emplace();
    std::size_t prisms = 0;
    own["angle"].forEach([&](const JsonNode&) { ++prisms; });
    b.rosette->angle = own["angle"].numbers(prisms);
    b.rosette->speed = own["speed"].numbers(prisms);
    b.rosette->phase = own["phase"].numbers(prisms);
    if (own.has("left")) b.rosette->left = own["left"].numbers(b.rings);
    if (own.has("up")) b.rosette->up = own["up"].numbers(b.rings);
    if (own.has("mirror")) {
      const JsonNode mirror = own["mirror"];
      mirror.keys({"tilt", "speed", "phase"});
      b.rosette->mirror = {mirror["tilt"].number(), mirror["speed"].number(), mirror["phase"].number()};
    }
  }
  if (node.has("sweep")) b.sweep = node["sweep"].number(0, b.period);
  if (node.has("intensity_full_scale")) sensor.intensityFullScale = node["intensity_full_scale"].number(1e-9);
  if (node.has("origin_left")) b.originLeft = node["origin_left"].numbers(b.rings);
  if (node.has("origin_up")) b.originUp = node["origin_up"].numbers(b.rings);
  return sensor;
}

ReasonCounts reasonsOf(const JsonNode& node, std::uint64_t beams) {
  ReasonCounts counts;
  std::uint64_t sum = 0;
  node.forEachEntry([&](const std::string& name, const JsonNode& count) {
    const ReasonEntry* known = findReason(name);
    if (known == nullptr) count.fail(fmt::format("'{}' is not a reason", name));
    counts[static_cast<std::uint8_t>(known->reason)] = count.integer<std::uint64_t>(1, beams);
    sum += count.integer<std::uint64_t>();
  });
  if (sum != beams) node.fail(fmt::format("add up to {} beams, not {}", sum, beams));
  return counts;
}

std::map<std::uint16_t, ObjectCount> objectCountsOf(const JsonNode& node, const Ontology& ontology) {
  std::map<std::uint16_t, ObjectCount> counts;
  node.forEach([&](const JsonNode& item) {
    item.keys({"id", "name", "objects", "with_points"});
    ObjectCount count;
    count.objects = item["objects"].integer<std::uint64_t>(1);
    count.withPoints = item["with_points"].integer<std::uint64_t>(0, count.objects);
    const std::uint16_t id = classOf(item, ontology);
    if (!counts.emplace(id, count).second) item["id"].fail(fmt::format("class {} is counted twice", id));
  });
  return counts;
}

ScanRecord scanOf(const JsonNode& node, const Manifest& manifest) {
  node.keys({"sensor", "method", "time", "world_from_sensor", "beams", "points", "instances", "points_per_class"},
            {"unresolved", "reasons", "vehicle_from_sensor", "revolution"});
  ScanRecord scan;
  scan.sensor = node["sensor"].text();
  if (node.has("revolution")) scan.revolution = node["revolution"].integer<std::uint32_t>();
  const auto sensor = std::find_if(manifest.sensors.begin(), manifest.sensors.end(),
                                   [&](const SensorRecord& known) { return known.name == scan.sensor; });
  if (sensor == manifest.sensors.end()) node["sensor"].fail(fmt::format("no sensor is named '{}'", scan.sensor));
  scan.method = node["method"].text();
  scan.time = node["time"].number();
  node["world_from_sensor"].forEach([&](const JsonNode& pose) { scan.worldFromSensor.push_back(poseOf(pose)); });
  if (scan.worldFromSensor.empty()) node["world_from_sensor"].fail("has no pose");
  if (node.has("vehicle_from_sensor")) {
    scan.vehicleFromSensor = poseOf(node["vehicle_from_sensor"]);
  } else if (!sensor->vehicleFromSensor) {
    node.fail("key 'vehicle_from_sensor' is missing, as in the scan's sensor");
  }
  scan.beams = node["beams"].integer<std::uint64_t>();
  scan.points = node["points"].integer<std::uint64_t>();
  if (node.has("unresolved")) scan.unresolved = node["unresolved"].integer<std::uint64_t>(1, scan.beams);
  if (node.has("reasons")) scan.beamsPerReason = reasonsOf(node["reasons"], scan.beams);
  scan.instances = node["instances"].integer<std::uint32_t>();
  node["points_per_class"].forEach([&](const JsonNode& item) {
    item.keys({"id", "name", "points"});
    const std::uint16_t id = classOf(item, manifest.ontology);
    if (!scan.pointsPerClass.emplace(id, item["points"].integer<std::uint64_t>()).second) {
      item["id"].fail(fmt::format("class {} is counted twice", id));
    }
  });
  return scan;
}

ShardRecord shardOf(const JsonNode& node) {
  node.keys({"file", "split", "sha256", "bytes", "samples"}, {"samples_sha256"});
  ShardRecord shard;
  shard.file = node["file"].text();
  shard.split = node["split"].text();
  // Overwriting a dataset removes the files that its manifest names, so no name may lead outside of the dataset's
  // folder.
  if (!isShardName(shard.file) || !shard.file.starts_with(shard.split + "/")) {
    node["file"].fail(
        fmt::format("'{}' is not a shard of the split '{}' (SPLIT/SPLIT-000000.tar)", shard.file, shard.split));
  }
  shard.sha256 = node["sha256"].sha256();
  shard.bytes = node["bytes"].integer<std::uint64_t>();
  shard.samples = node["samples"].integer<std::uint64_t>();
  constexpr std::uint64_t kTarBlock = 512;  // each sample has at least one member, whose header is one block
  if (shard.samples > shard.bytes / kTarBlock) {
    node["samples"].fail(fmt::format("a shard of {} bytes cannot have {} samples", shard.bytes, shard.samples));
  }
  if (node.has("samples_sha256")) shard.samplesSha256 = node["samples_sha256"].sha256();
  return shard;
}

SequenceRecord sequenceOf(const JsonNode& node) {
  node.keys({"name", "scene", "seed", "trajectory", "moving"}, {"scene_file", "vehicle"});
  SequenceRecord sequence;
  sequence.name = node["name"].text();
  sequence.scene = node["scene"].text();
  sequence.seed = node["seed"].integer<std::uint64_t>();
  sequence.trajectory = node["trajectory"].text();
  sequence.moving = node["moving"].boolean();
  if (node.has("scene_file")) sequence.sceneFile = node["scene_file"].text();
  if (node.has("vehicle")) sequence.vehicle = node["vehicle"].text();
  return sequence;
}

SampleRecord sampleOf(const JsonNode& node, const Manifest& manifest) {
  node.keys({"key", "split", "shard", "members", "scans"}, {"xxh3", "objects", "draws", "time"});
  SampleRecord sample;
  sample.key = node["key"].text();
  if (sample.key.empty() || sample.key.find_first_of("./") != std::string::npos || sample.key != oneLine(sample.key)) {
    node["key"].fail(fmt::format("'{}' is not a key (text without dots, slashes and control characters)", sample.key));
  }
  sample.split = node["split"].text();
  sample.shard = node["shard"].integer<std::uint32_t>();
  if (sample.shard >= manifest.shards.size()) {
    node["shard"].fail(
        fmt::format("{} is out of range: the dataset has {} shards", sample.shard, manifest.shards.size()));
  }
  if (manifest.shards[sample.shard].split != sample.split) {
    node["split"].fail(fmt::format("is '{}', but shard {} belongs to '{}'", sample.split, sample.shard,
                                   manifest.shards[sample.shard].split));
  }
  node["members"].forEach([&](const JsonNode& item) {
    std::string member = item.text();
    if (!member.starts_with(sample.key + ".")) {
      item.fail(fmt::format("'{}' does not start with the sample's key '{}'", member, sample.key));
    }
    sample.members.push_back(std::move(member));
  });
  if (node.has("xxh3")) {
    node["xxh3"].forEach([&](const JsonNode& item) { sample.xxh3.push_back(item.xxh3()); });
    if (sample.xxh3.size() != sample.members.size()) {
      node["xxh3"].fail(fmt::format("has {} entries for {} members", sample.xxh3.size(), sample.members.size()));
    }
  }
  node["scans"].forEach([&](const JsonNode& item) { sample.scans.push_back(scanOf(item, manifest)); });
  if (node.has("objects")) sample.objects = objectCountsOf(node["objects"], manifest.ontology);
  if (node.has("time")) sample.time = node["time"].number();
  if (node.has("draws")) {
    node["draws"].forEachEntry([&](const std::string& key, const JsonNode& value) {
      sample.draws.push_back(value.isText() ? DrawnValue{key, value.text()}
                                            : DrawnValue{key, value.numberText(), true});
    });
  }
  return sample;
}

void checkVersion(const JsonNode& root, const Json& json, const std::string& file) {
  const bool ours = json.is_object() && json.contains("schema_version") && json["schema_version"].is_number_integer() &&
                    json.contains("program") && json["program"].is_object() &&
                    json["program"].value("name", Json()) == "scanmill";
  if (!ours) throw InputError({file}, "is not a manifest of scanmill");
  const JsonNode version = root["schema_version"];
  const std::int64_t found = json["schema_version"].get<std::int64_t>();
  if (found > Manifest::kSchemaVersion) {
    version.fail(fmt::format("{} is newer than this program, which reads up to {}: update scanmill", found,
                             Manifest::kSchemaVersion));
  }
  if (found < 1) version.fail(fmt::format("{} is not a version: the first version is 1", found));
}

Manifest manifestOf(const JsonNode& root) {
  root.keys({"schema_version", "program", "name", "seed", "pipeline", "units", "frames", "scans", "formats", "ontology",
             "sensors", "modelled", "shards", "samples"},
            {"sequences", "files", "about", "plan_sha256", "method_choice", "digest", "stages"});
  const bool old = root["schema_version"].integer<int>() < 3;
  if (!old) root.expectKeys({"sequences", "files"});
  Manifest m;
  m.programVersion = root["program"].keys({"name", "version"})["version"].text();
  m.name = root["name"].text();
  m.seed = root["seed"].integer<std::uint64_t>();
  const JsonNode pipeline = root["pipeline"];
  pipeline.keys({"sha256", "text"});
  m.pipelineSha256 = pipeline["sha256"].sha256();
  m.pipelineText = pipeline["text"].text();
  if (root.has("about")) {
    const JsonNode about = root["about"];
    about.keys({}, {"description", "license", "creator", "url", "citation"});
    about.forEachEntry([&](const std::string& key, const JsonNode& text) { m.about.emplace(key, text.text()); });
  }
  if (root.has("plan_sha256")) m.planSha256 = root["plan_sha256"].sha256();
  const JsonNode units = root["units"];
  units.keys({"length", "time", "angle"});
  const auto unit = [&](const std::string& quantity, std::string_view expected) {
    if (units[quantity].text() != expected) units[quantity].fail(fmt::format("is not '{}'", expected));
  };
  unit("length", "metres");
  unit("time", "seconds");
  unit("angle", "radians");
  root["frames"].forEachEntry([](const std::string&, const JsonNode& meaning) { meaning.text(); });
  const JsonNode scans = root["scans"];
  scans.keys({"organised", "deskewed", "columns"});
  m.organised = scans["organised"].boolean();
  m.deskewed = scans["deskewed"].boolean();
  m.columns = scans["columns"].texts();
  root["formats"].forEach([&](const JsonNode& item) {
    item.keys({"name", "suffix", "max_error"});
    m.formats.push_back({item["name"].text(), item["suffix"].text(), item["max_error"].number(0)});
  });
  m.ontology = ontologyOf(root["ontology"]);
  root["sensors"].forEach([&](const JsonNode& item) { m.sensors.push_back(sensorOf(item)); });
  if (root.has("sequences")) {
    root["sequences"].forEach([&](const JsonNode& item) { m.sequences.push_back(sequenceOf(item)); });
  }
  if (root.has("files")) {
    root["files"].forEach([&](const JsonNode& item) {
      item.keys({"file", "xxh3"});
      m.files.push_back({item["file"].text(), item["xxh3"].xxh3()});
    });
  }
  m.modelled = modelledOf(root["modelled"], old);
  // Only manifests of earlier versions have the keys `method_choice`, and `stages` with times, which differ between
  // machines.
  if (root.has("stages")) root["stages"].forEachEntry([](const std::string&, const JsonNode& time) { time.number(0); });
  root["shards"].forEach([&](const JsonNode& item) { m.shards.push_back(shardOf(item)); });
  if (root.has("digest")) root["digest"].sha256();
  std::set<std::string> keys;
  root["samples"].forEach([&](const JsonNode& item) {
    m.samples.push_back(sampleOf(item, m));
    if (!keys.insert(m.samples.back().key).second) item["key"].fail("another sample has this key");
  });
  return m;
}

// Returns the text of a file that describes the samples of a shard. Throws InputError if its SHA-256 is not the stated
// one, or if it is larger than any description of a shard of this size, which has its samples' descriptions, too.
std::string soundText(const std::filesystem::path& file, const ShardRecord& shard) {
  constexpr std::uint64_t kLeast = 1 << 20;
  std::error_code error;
  const std::uint64_t bytes = std::filesystem::file_size(file, error);
  std::string text = error || bytes / 4 <= kLeast + shard.bytes ? readFile(file) : std::string();
  if (sha256(text) == shard.samplesSha256) return text;
  throw InputError({file.string()}, "was changed since it was written: its SHA-256 differs from the manifest");
}

// Parses the text that describes a shard's samples, and stores each sample in `samples` at the sample's number.
// `samples` has the size of the complete dataset.
void parseSamples(const std::string& text, const std::filesystem::path& folder, std::uint32_t number,
                  const Manifest& head, std::vector<SampleRecord>& samples) {
  const ShardRecord& shard = head.shards[number];
  const std::string file = (folder / samplesFileOf(shard.file)).string();
  const Json json = parseJson(text, file);
  const JsonNode root(json, "", file);
  root.keys({"shard", "numbers", "samples"});
  std::vector<std::uint64_t> numbers;
  root["numbers"].forEach([&](const JsonNode& item) {
    numbers.push_back(item.integer<std::uint64_t>());
    if (numbers.back() >= samples.size())
      item.fail(fmt::format("is not below {}, the number of samples", samples.size()));
  });
  std::size_t next = 0;
  root["samples"].forEach([&](const JsonNode& item) {
    SampleRecord sample = sampleOf(item, head);
    if (sample.shard != number) item["shard"].fail(fmt::format("is not {}, the number of {}", number, shard.file));
    if (next >= numbers.size() || !samples[numbers[next]].key.empty())
      item.fail("has no number, or the number of another sample");
    samples[numbers[next++]] = std::move(sample);
  });
  if (next != shard.samples) root["samples"].fail(fmt::format("has {} entries, not {}", next, shard.samples));
}

// Adds the samples that the files beside the shards describe to a manifest: see readManifest().
Manifest described(Manifest manifest, const std::filesystem::path& folder,
                   std::map<std::uint32_t, std::string>& undescribed) {
  const std::filesystem::path file = folder / kManifestName;
  const auto inFile = [](const ShardRecord& shard) { return !shard.samplesSha256.empty(); };
  if (std::none_of(manifest.shards.begin(), manifest.shards.end(), inFile)) return manifest;
  constexpr std::uint64_t kMost = 10'000'000;  // 2 GB
  std::uint64_t count = 0;
  for (const ShardRecord& shard : manifest.shards) {
    count += std::min(shard.samples, kMost + 1);
    if (count > kMost) throw InputError({file.string()}, fmt::format("states more than {} samples", kMost));
  }
  std::vector<SampleRecord> samples(count);
  for (std::uint32_t shard = 0; shard < manifest.shards.size(); ++shard) {
    const ShardRecord& record = manifest.shards[shard];
    std::string text;
    try {
      text = soundText(folder / samplesFileOf(record.file), record);
    } catch (const InputError& error) {
      undescribed[shard] = error.what();
      continue;
    }
    parseSamples(text, folder, shard, manifest, samples);
  }
  std::set<std::string_view> keys;
  for (const SampleRecord& sample : samples) {
    if (!sample.key.empty() && !keys.insert(sample.key).second) {
      throw InputError({file.string()}, "has two samples " + sample.key);
    }
  }
  manifest.samples = std::move(samples);
  return manifest;
}

}  // namespace

Manifest parseManifest(const std::string& text, const std::string& file) {
  const Json json = parseJson(text, file);
  const JsonNode root(json, "", file);
  checkVersion(root, json, file);
  return manifestOf(root);
}

Manifest readManifest(const std::filesystem::path& folder) {
  std::map<std::uint32_t, std::string> undescribed;
  Manifest manifest = readManifest(folder, undescribed);
  if (undescribed.empty()) return manifest;
  const std::size_t others = undescribed.size() - 1;
  throw InputError(fmt::format(
      "{}{}\nnext: `scanmill regenerate {}` makes it again", undescribed.begin()->second,
      others == 0 ? "" : fmt::format(" (and so are {} more files that describe samples)", others), folder.string()));
}

Manifest readManifest(const std::filesystem::path& folder, std::map<std::uint32_t, std::string>& undescribed) {
  const std::filesystem::path file = folder / kManifestName;
  std::error_code ignored;
  if (std::filesystem::is_directory(folder, ignored) && !std::filesystem::exists(file, ignored)) {
    throw InputError({folder.string()},
                     "has no manifest.json: it is not a dataset, or the run that wrote it did not end: continue it by "
                     "generate --resume, or start again with --overwrite");
  }
  const std::string text = readFile(file);
  try {
    return described(parseManifest(text, file.string()), folder, undescribed);
  } catch (const InputError& error) {
    try {
      expectUnchanged(file, text);
    } catch (const InputError& changed) {  // files that contradict it may be sound
      throw InputError(fmt::format("{}; {}", changed.what(), error.what()));
    }
    throw;
  }
}

}  // namespace scanmill
