
#include <algorithm>
#include <map>

#include "base/append_new.h"
#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/short_text.h"
#include "base/terminal.h"
#include "config/resources.h"
#include "dataset/json_record.h"
#include "dataset/names.h"

namespace scanmill {

void describe(RecordKeys& keys, FormatRecord& format) {
  keys("name", format.name);
  keys("suffix", format.suffix);
  keys("max_error", format.maxErrorMetres, within(0));
}

void describe(RecordKeys& keys, FileRecord& file) {
  keys("file", file.file);
  keys("xxh3", file.xxh3, kXxh3Digits);
}

void describe(RecordKeys& keys, SequenceRecord& sequence) {
  keys("name", sequence.name);
  keys("scene", sequence.scene);
  keys("seed", sequence.seed);
  keys("trajectory", sequence.trajectory);
  keys("moving", sequence.moving);
  keys.optional("scene_file", sequence.sceneFile);
  keys.optional("vehicle", sequence.vehicle);
}

void describe(RecordKeys& keys, ModelledItem& item) {
  keys("topic", item.topic);
  keys("left_out", item.leftOut);
  keys("text", item.text);
  keys.optional("sensor", item.sensor);
  keys.optional("options", item.options);
  keys.optional("scenes", item.scenes);
  keys.optional("parts", item.parts, wholeNumber(1));
}

namespace {

OrderedJson reasonsJson(const ScanRecord& scan) {
  OrderedJson json = OrderedJson::object();
  for (const auto& [reason, beams] : scan.beamsPerReason) {
    const ReasonEntry* const entry = findReason(reason);
    if (entry == nullptr) throw Error("no reason has the value {}", reason);
    json[std::string(entry->name)] = beams;
  }
  return json;
}

// Reads the counts that reasonsJson() writes. Throws InputError unless their sum is `beams` (number of beams).
ReasonCounts reasonsOf(const JsonNode& node, std::uint64_t beams) {
  ReasonCounts counts;
  std::uint64_t sum = 0;
  node.forEachEntry([&](const std::string& name, const JsonNode& count) {
    const ReasonEntry* const entry = findReason(name);
    if (entry == nullptr) count.fail("'{}' is not a reason", name);
    counts[static_cast<std::uint8_t>(entry->reason)] = count.integer<std::uint64_t>(1, beams);
    sum += count.integer<std::uint64_t>();
  });
  if (sum != beams) node.fail("add up to {} beams, not {}", sum, beams);
  return counts;
}

}  // namespace

static void describe(RecordKeys& keys, SemanticClass& semantic) {
  keys("id", semantic.id);
  keys("name", semantic.name);
  keys("color", semantic.color);
  keys("thing", semantic.thing);
  keys.optionalIf(semantic.roadUser, "road_user", semantic.roadUser);
  keys.optional("aliases", semantic.aliases);
}

void describe(RecordKeys& keys, Ontology& ontology) {
  keys("name", ontology.name);
  keys("source", ontology.source);
  keys("classes", ontology.classes, distinct("id"), distinct("name"));
}

void describe(RecordKeys& keys, ShardRecord& shard) {
  constexpr std::uint64_t kTarBlock = 512;  // each sample has at least one member, whose header is one block
  keys("file", shard.file);
  // Overwriting a dataset removes the files that its manifest names, so no name may lead outside of the dataset's
  // folder.
  keys("split", shard.split, [&](const JsonNode& node) {
    if (isShardName(shard.file) && shard.file.starts_with(shard.split + "/")) return;
    node.fail("'{}' is not a shard of the split '{}' (SPLIT/SPLIT-000000.tar)", shard.file, shard.split);
  });
  keys("sha256", shard.sha256, kSha256Digits);
  keys("bytes", shard.bytes);
  keys("samples", shard.samples, [&](const JsonNode& node) {
    if (shard.samples <= shard.bytes / kTarBlock) return;
    node.fail("a shard of {} bytes cannot have {} samples", shard.bytes, shard.samples);
  });
  keys.optional("samples_sha256", shard.samplesSha256, kSha256Digits);
}

static void describe(RecordKeys& keys, ListedBeams& beams) {
  keys("azimuth", beams.azimuth);
  keys("elevation", beams.elevation);
  keys("time", beams.time);
  std::vector<double> coordinates;  // x, y, z of the first beam's origin, x of the second beam's, ...
  for (const Vec3f& o : beams.origin) coordinates.insert(coordinates.end(), {double{o.x}, double{o.y}, double{o.z}});
  keys.optional("origin", coordinates);
  if (!keys.reads()) return;
  for (std::size_t i = 0; i + 2 < coordinates.size(); i += 3) {
    beams.origin.push_back(static_cast<Vec3f>(Vec3d{coordinates[i], coordinates[i + 1], coordinates[i + 2]}));
  }
}

static void describe(RecordKeys& keys, Rosette::Mirror& mirror) {
  keys("tilt", mirror.tilt);
  keys("speed", mirror.speed);
  keys("phase", mirror.phase);
}

static void describe(RecordKeys& keys, Rosette& rosette) {
  keys("angle", rosette.angle);
  keys("speed", rosette.speed, numberCount(rosette.angle.size()));
  keys("phase", rosette.phase, numberCount(rosette.angle.size()));
  keys.optional("left", rosette.left);
  keys.optionalIf(!rosette.left.empty(), "up", rosette.up, numberCount(rosette.left.size()));
  keys.optionalIf(rosette.mirror.has_value(), "mirror", rosette.mirror);
}

void describe(RecordKeys& keys, SensorRecord& sensor) {
  BeamTable& b = sensor.beams;
  keys("name", sensor.name, [&](const JsonNode& node) {
    if (sensor.name != oneLine(sensor.name)) node.fail("has control characters");
  });
  keys("model", b.model);
  keys("source", b.source);
  keys("rings", b.rings, wholeNumber(1, 65536));
  keys("columns", b.columns, wholeNumber(1, 65536));
  keys("period", b.period, within(0));
  keys("clockwise", b.clockwise);
  keys("top_down", b.topDown);
  keys("min_range", b.minRange, within(0));
  keys("max_range", b.maxRange, within(b.minRange));
  keys("first_azimuth", b.firstAzimuth);
  keys("field", b.field, within(0, 2 * kPi));
  keys("origin_offset", b.originOffset);
  keys("origin_height", b.originHeight);
  keys("elevation", b.elevation, numberCount(b.rings));
  keys("azimuth_offset", b.azimuthOffset, numberCount(b.rings));
  keys("firing_offset", b.firingOffset, numberCount(b.rings));
  keys.optional("vehicle_from_sensor", sensor.vehicleFromSensor);
  keys.optional("choice", sensor.choice);
  // BeamTable stores listed beams, a rosette or neither in a variant. RecordKeys needs objects of these types, so
  // copies are described; if the record is read, they are then moved into the table.
  std::shared_ptr<const ListedBeams> listed = b.listed();
  keys.optional("beams", listed, [&](const JsonNode& node) {
    for (const char* const key : {"azimuth", "elevation", "time"}) node[key].numbers(b.size());
    if (node.has("origin")) node["origin"].numbers(3 * b.size());
  });
  std::optional<Rosette> rosette;
  if (b.rosette() != nullptr) rosette = *b.rosette();
  keys.optionalIf(rosette.has_value(), "rosette", rosette, [&](const JsonNode& node) {
    if (node.has("left")) node["left"].numbers(b.rings);
  });
  if (keys.reads() && rosette) b.pattern = std::move(*rosette);
  if (keys.reads() && listed != nullptr) b.pattern = std::move(listed);
  keys.optionalIf(b.sectors > 1, "sectors", b.sectors, wholeNumber(1, 256));
  keys.optionalIf(b.sweep > 0, "sweep", b.sweep, within(0, b.period));
  keys.optionalIf(sensor.intensityFullScale != 1, "intensity_full_scale", sensor.intensityFullScale, within(1e-9));
  keys.optional("origin_left", b.originLeft, numberCount(b.rings));
  keys.optional("origin_up", b.originUp, numberCount(b.rings));
}

void describeClassName(RecordKeys& keys, const char* key, const std::uint16_t& id) {
  const Ontology* const ontology = keys.context.ontology;
  keys.custom(
      key, [&] { return ontology == nullptr ? kAbsent : OrderedJson(requireClass(id, key, *ontology).name); },
      [&](const JsonNode& node) {
        const SemanticClass* const semantic = ontology->find(id);
        if (semantic == nullptr) node.fail("class {} is not in ontology '{}'", id, ontology->name);
        if (node.text() != semantic->name) node.fail("class {} is '{}' in the ontology", id, semantic->name);
      });
}

// Number of a scan's points that have the class `id`.
struct ClassPoints {
  std::uint16_t id = 0;
  std::uint64_t points = 0;
};

static void describe(RecordKeys& keys, ClassPoints& entry) {
  keys("id", entry.id);
  describeClassName(keys, "name", entry.id);
  keys("points", entry.points);
}

// Numbers of a sample's objects that have the class `id`.
struct ClassObjects {
  std::uint16_t id = 0;
  ObjectCount count;
};

static void describe(RecordKeys& keys, ClassObjects& entry) {
  keys("id", entry.id);
  describeClassName(keys, "name", entry.id);
  keys("objects", entry.count.objects, wholeNumber(1));
  keys("with_points", entry.count.withPoints, wholeNumber(0, entry.count.objects));
}

void describe(RecordKeys& keys, ScanRecord& scan) {
  keys("sensor", scan.sensor, [&](const JsonNode& node) {
    const std::vector<SensorRecord>& sensors = keys.context.head->sensors;
    if (std::ranges::find(sensors, scan.sensor, &SensorRecord::name) != sensors.end()) return;
    node.fail("no sensor is named '{}'", scan.sensor);
  });
  keys.optional("revolution", scan.revolution);
  keys("method", scan.method);
  keys("time", scan.time);
  keys("world_from_sensor", scan.worldFromSensor, [&](const JsonNode& node) {
    if (scan.worldFromSensor.empty()) node.fail("has no pose");
  });
  keys.optional("vehicle_from_sensor", scan.vehicleFromSensor);
  keys("beams", scan.beams);
  keys("points", scan.points);
  keys.optional("unresolved", scan.unresolved, wholeNumber(1, scan.beams));
  keys("instances", scan.instances);
  std::vector<ClassPoints> classes;
  for (const auto& [id, points] : scan.pointsPerClass) classes.push_back({id, points});
  keys("points_per_class", classes, [&](const JsonNode& node) {
    for (std::size_t i = 0; i < classes.size(); ++i) {
      const bool isNew = scan.pointsPerClass.emplace(classes[i].id, classes[i].points).second;
      if (!isNew) node.item(i)["id"].fail("class {} is counted twice", classes[i].id);
    }
  });
  keys.customOptional(
      "reasons", [&] { return scan.beamsPerReason.empty() ? kAbsent : reasonsJson(scan); },
      [&](const JsonNode& node) { scan.beamsPerReason = reasonsOf(node, scan.beams); });
}

OrderedJson drawsJson(const SampleRecord& sample) {
  if (sample.draws.empty()) return kAbsent;
  OrderedJson json = OrderedJson::object();
  for (const DrawnValue& draw : sample.draws) {
    json[draw.key] = draw.number ? OrderedJson::parse(draw.value) : OrderedJson(draw.value);
  }
  return json;
}

void describe(RecordKeys& keys, SampleRecord& s) {
  const Manifest* const head = keys.context.head;  // only used by limits, which need a context with a manifest
  keys("key", s.key, [&](const JsonNode& node) {
    if (!s.key.empty() && s.key.find_first_of("./") == std::string::npos && s.key == oneLine(s.key)) return;
    node.fail("'{}' is not a key (text without dots, slashes and control characters)", s.key);
  });
  keys("split", s.split);
  keys("shard", s.shard, [&](const JsonNode& node) {
    const std::size_t shards = head->shards.size();
    if (s.shard >= shards) node.fail("{} is out of range: the dataset has {} shards", s.shard, shards);
    const std::string& split = head->shards[s.shard].split;
    if (split != s.split) node.fail("{} belongs to '{}', but the sample to '{}'", s.shard, split, s.split);
  });
  keys("members", s.members, [&](const JsonNode& node) {
    node.forEach([&](const JsonNode& item) {
      if (item.text().starts_with(s.key + ".")) return;
      item.fail("'{}' does not start with the sample's key '{}'", item.text(), s.key);
    });
  });
  keys("xxh3", s.xxh3, [&](const JsonNode& node) {
    node.forEach(kXxh3Digits);
    if (s.xxh3.size() != s.members.size()) {
      node.fail("has {} entries for {} members", s.xxh3.size(), s.members.size());
    }
  });
  keys("scans", s.scans, [&](const JsonNode& node) {
    for (std::size_t i = 0; i < s.scans.size(); ++i) {
      const auto sensor = std::ranges::find(head->sensors, s.scans[i].sensor, &SensorRecord::name);  // always found
      if (s.scans[i].vehicleFromSensor || sensor->vehicleFromSensor) continue;
      node.item(i).fail("key 'vehicle_from_sensor' is missing, as in the scan's sensor");
    }
  });
  std::vector<ClassObjects> objects;
  for (const auto& [id, count] : s.objects.value_or(std::map<std::uint16_t, ObjectCount>{})) {
    objects.push_back({id, count});
  }
  keys.optionalIf(s.objects.has_value(), "objects", objects, distinct("id"), [&](const JsonNode&) {
    s.objects.emplace();
    for (const ClassObjects& entry : objects) (*s.objects)[entry.id] = entry.count;
  });
  keys.customOptional(
      "draws", [&] { return drawsJson(s); },
      [&](const JsonNode& node) {
        node.forEachEntry([&](const std::string& key, const JsonNode& value) {
          s.draws.push_back(value.isText() ? DrawnValue{key, value.text()} : DrawnValue{key, value.numberText(), true});
        });
      });
  keys.optional("time", s.time);
}

std::vector<FileRecord> recordsOf(const FilesRead& read, const std::filesystem::path& folder) {
  std::vector<FileRecord> files;
  for (const auto& [file, hash] : read.hashes()) files.push_back({savedPath(file, folder), hash});
  std::ranges::sort(files);
  return files;
}

std::string addFiles(const std::vector<FileRecord>& added, std::vector<FileRecord>& files) {
  files.insert(files.end(), added.begin(), added.end());
  std::ranges::sort(files);
  files.erase(std::unique(files.begin(), files.end()), files.end());
  const auto changed = std::ranges::adjacent_find(files, std::ranges::equal_to(), &FileRecord::file);
  return changed == files.end() ? std::string() : changed->file;
}

void requireUnchangedFiles(const std::vector<FileRecord>& files, const std::filesystem::path& folder,
                           const std::filesystem::path& dataset) {
  constexpr std::size_t kMostNamed = 5;  // files in the message
  std::vector<std::string> changed;
  std::map<std::filesystem::path, std::string> currentHashes;  // empty: the file is missing
  for (const FileRecord& record : files) {
    const std::filesystem::path file = fileOfSavedPath(record.file, folder);
    const auto [hash, isNew] = currentHashes.try_emplace(file);
    if (isNew && isFile(file)) hash->second = xxh3OfFile(file);
    if (hash->second != record.xxh3) appendNew({file.string()}, changed);
  }
  if (changed.empty()) return;
  throw InputError({dataset.string()},
                   "has shards that were made before these files changed or went: {}: restore the files, "
                   "add --overwrite to start again, or give --resume=anyway to keep these shards",
                   shortList(changed, kMostNamed));
}

OrderedJson ontologyJson(const Ontology& ontology) {
  return jsonOf(ontology, ontology.name);
}

}  // namespace scanmill
