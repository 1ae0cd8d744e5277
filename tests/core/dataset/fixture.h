#pragma once

// A small dataset: two sensors, two formats, three splits, scans that follow from sample and sensor numbers.

#include <fmt/core.h>

#include <cstdlib>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "base/file.h"
#include "base/hash.h"
#include "base/random.h"
#include "dataset/manifest.h"
#include "dataset/reader.h"
#include "dataset/shard_writer.h"
#include "formats/format.h"
#include "tests/support/message_of.h"
#include "tests/support/packed_dataset.h"
#include "tests/support/temporary_folder.h"

namespace scanmill {

inline BeamTable testBeams(std::uint32_t rings, std::uint32_t columns) {
  BeamTable beams;
  beams.model = "test \"head\" \xC3\xA9";  // quotes and UTF-8 must survive
  beams.source = "closed form";
  beams.rings = rings;
  beams.columns = columns;
  beams.minRange = 0.5;
  beams.maxRange = 80;
  beams.period = 0.1;
  beams.clockwise = true;
  beams.topDown = true;
  beams.firstAzimuth = radians(123.4);
  beams.originOffset = 0.027;
  beams.originHeight = 0.0362;
  for (std::uint32_t ring = 0; ring < rings; ++ring) {
    beams.elevation.push_back(radians(10.0 - 1.0 / 3 * ring));
    beams.azimuthOffset.push_back(radians(ring % 2 ? 0.7 : -0.7));
    beams.firingOffset.push_back(1e-6 * ring);
    beams.originLeft.push_back(ring % 2 ? 0.026 : -0.026);
    beams.originUp.push_back(0.2 - 0.001 * ring);
  }
  fillBeams(beams);
  return beams;
}

inline Manifest testManifest() {
  Manifest m;
  m.programVersion = "0.1.0";
  m.name = "small";
  m.pipelineText = "name: small\n# a tab\tand a quote \"\nseed: 18446744073709551615\n";
  m.pipelineSha256 = sha256(m.pipelineText);
  m.planSha256 = sha256("plan");
  m.seed = 18446744073709551615u;
  m.columns = {"x", "y", "z", "intensity", "label", "instance", "ring", "column", "time", "range_true"};
  m.formats = {{"pcd", "pcd", 0}, {"csv", "csv", 0}};
  m.ontology = {"ours",
                "made for tests",
                {{0, "unlabeled", {0, 0, 0}, false, {}},
                 {7, "road", {128, 64, 128}, false, {"street", "lane"}},
                 {65535, "car", {0, 0, 255}, true, {}}}};
  const Pose mount{fromYawPitchRoll(0.3, 0.1, -0.2), {1.2, 0, 1.9}};
  m.sensors = {{"top", testBeams(4, 16), mount}, {"Rear", testBeams(1, 8), Pose{}}};
  m.sequences = {{"street-1-drive", "street", "scenes/street.yaml", 1, "drive", true, "scanmill:scenes/vehicle.yaml"}};
  m.files = {{"scenes/street.yaml", xxh3("objects: []")}, {"scenes/wall.obj", xxh3("v 0 0 0")}};
  m.modelled = {{"effect speckle", "random echoes", false, "top", "{looks: 3}"},
                {"glass", "no material of the scene is transparent", true, "", "", {"street-s1"}, 3}};
  return m;
}

// Two beams in three return; labels cycle through the ontology; cars are instances 1 to 3.
inline Scan testScan(const BeamTable& beams, std::uint32_t number) {
  Scan scan;
  scan.rings = beams.rings;
  scan.columns = beams.columns;
  for (std::uint32_t beam = 0; beam < beams.size(); ++beam) {
    const RandomBlock random = randomBlock({.scene = number, .beam = beam});
    if (random[0] % 3 == 0) continue;
    const auto range = static_cast<float>(beams.minRange + uniform(random[1]) * (beams.maxRange - beams.minRange));
    const bool car = random[2] % 3 == 2;
    scan.position.push_back(static_cast<Vec3f>(beams.direction[beam] * static_cast<double>(range)));
    scan[kIntensity].push_back(static_cast<float>(uniform(random[3])));
    scan[kLabel].push_back(car ? 65535 : random[2] % 3 == 1 ? 7 : 0);
    scan[kInstance].push_back(car ? 1 + random[2] / 3 % 3 : 0);
    scan[kRing].push_back(static_cast<std::uint16_t>(beam / beams.columns));
    scan[kColumn].push_back(static_cast<std::uint16_t>(beam % beams.columns));
    scan[kTime].push_back(beams.time[beam]);
    scan[kRangeTrue].push_back(range);
  }
  return scan;
}

inline Scan organised(const Scan& dense) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  Scan image;
  image.rings = dense.rings;
  image.columns = dense.columns;
  image.organised = true;
  const std::size_t beams = std::size_t{dense.rings} * dense.columns;
  image.position.assign(beams, {kNaN, kNaN, kNaN});
  const auto beamOf = [&](std::size_t i) { return std::size_t{dense[kRing][i]} * dense.columns + dense[kColumn][i]; };
  for (std::size_t i = 0; i < dense.size(); ++i) image.position[beamOf(i)] = dense.position[i];
  visitTable(dense, [&]<class T>(auto key, const std::vector<T>& values) {
    if (values.empty()) return;
    image[key].assign(beams, static_cast<T>(key.row.none));
    for (std::size_t i = 0; i < values.size(); ++i) image[key][beamOf(i)] = values[i];
  });
  return image;
}

inline ScanRecord testRecord(const SensorRecord& sensor, const Scan& scan, double time) {
  ScanRecord record;
  record.sensor = sensor.name;
  record.method = "ray_tracing";
  record.time = time;
  record.worldFromSensor = {sensor.vehicleFromSensor.value(),
                            {fromYawPitchRoll(1.0 / 3, 0, 0), {4e5 + 1.0 / 3, 5e6 + time, 0.1}}};
  record.worldFromSensor[1].translation = record.worldFromSensor[0].translation + Vec3d{1.0 / 3, 0, 0};
  record.beams = sensor.beams.size();
  std::vector<std::uint32_t> instances;
  for (std::size_t i = 0; i < scan.size(); ++i) {
    if (!isFinite(scan.position[i])) continue;
    ++record.points;
    ++record.pointsPerClass[scan[kLabel][i]];
    const std::uint32_t id = scan[kInstance][i];
    if (id != 0 && std::find(instances.begin(), instances.end(), id) == instances.end()) instances.push_back(id);
  }
  record.instances = static_cast<std::uint32_t>(instances.size());
  return record;
}

inline std::string encode(const std::string& format, const Scan& scan) {
  Value none;
  none.kind = Value::Kind::Map;
  Fields options(none, "format");
  return requireFormat(format, {}).make(options)->encode(scan);
}

inline Sample testSample(const Manifest& manifest, std::uint32_t number, const std::string& key,
                         const std::string& split) {
  Sample sample{{.key = key, .split = split}, {}};
  for (std::size_t s = 0; s < manifest.sensors.size(); ++s) {
    const SensorRecord& sensor = manifest.sensors[s];
    const Scan dense = testScan(sensor.beams, number * 10 + static_cast<std::uint32_t>(s));
    const Scan scan = manifest.organised ? organised(dense) : dense;
    sample.scans.push_back(testRecord(sensor, scan, 0.1 * number));
    for (const FormatRecord& format : manifest.formats) {
      sample.files.push_back({memberSuffix(sample.scans.back(), format.suffix), encode(format.name, scan)});
    }
  }
  return sample;
}

// Nine frames, six in train (several small shards), two in val, one in test.
inline Manifest writeTestDataset(const std::filesystem::path& folder, bool overwrite = false, bool images = false,
                                 std::uint64_t shardBytes = 30000) {
  Manifest manifest = testManifest();
  manifest.organised = images;
  PackedDataset writer(folder, overwrite, shardBytes);
  for (std::uint32_t i = 0; i < 9; ++i) {
    const std::string split = i < 6 ? "train" : i < 8 ? "val" : "test";
    writer.add(testSample(manifest, i, split + "_street-1-drive-00000" + std::to_string(i), split));
  }
  writer.finish(manifest);
  return manifest;
}

// Relative names of all files, sorted.
inline std::vector<std::string> filesOf(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_directory()) names.push_back(std::filesystem::relative(entry.path(), folder).generic_string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

inline Sample plainSample(const std::string& key, std::size_t bytes, const std::string& split = "train") {
  return {{.key = key, .split = split}, {{"bin", std::string(bytes, 'x')}}};
}

using Members = std::vector<std::pair<std::string, std::string>>;

inline Members membersOf(const std::filesystem::path& shard) {
  Members members;
  readTar(shard, [&](const std::string& name, std::string_view bytes) { members.emplace_back(name, bytes); });
  return members;
}

inline void writeMembers(const std::filesystem::path& shard, const Members& members) {
  ShardFile file(shard.parent_path(), shard);
  for (const auto& [name, bytes] : members) file.add(name, bytes);
  file.close();
}

// Members with unusual names and sizes.
inline Members oddMembers() {
  return {{"a-0.json", "{}"},
          {"a-0.empty", ""},
          {"a-0.block", std::string(512, 'b')},
          {"a-0.zeros", std::string(2000, '\0')},
          {std::string(150, 'k') + ".long", "after a pax header"},
          {"b-0.large", std::string(3000000, 'l')},
          {"b-0.last", "z"}};
}

// Writes a shard of one sample, and keeps its record in the folder. Returns the manifest of the record.
inline Manifest addShard(DatasetFolder& folder, std::uint64_t number, std::size_t bytes = 100) {
  ShardWriter shard(folder.staging(), shardName("train", number), "train");
  shard.add(plainSample("k-" + std::to_string(number), bytes));
  ShardPart part = shard.finish();
  Manifest manifest = testManifest();
  manifest.shards = {part.shard};
  manifest.samples = part.samples;
  folder.storeRecord({"plan", {number}, manifest});
  return manifest;
}

// Returns what python3-jsonschema says against a text by docs/NAME.schema.json; empty: it satisfies the schema.
inline std::string schemaErrors(const std::string& schema, const std::string& text) {
  const TemporaryFolder folder;
  const auto script = folder.write("validate.py",
                                   "import json, sys, jsonschema\nschema = json.load(open(sys.argv[1]))\n"
                                   "validator = jsonschema.Draft202012Validator\nvalidator.check_schema(schema)\n"
                                   "validator(schema).validate(json.load(open(sys.argv[2])))\n");
  const auto errors = folder.path() / "errors";
  const std::string command =
      fmt::format("/usr/bin/python3 '{}' '{}/docs/{}.schema.json' '{}' 2> '{}'", script.string(), SCANMILL_SOURCE_DIR,
                  schema, folder.write("text.json", text).string(), errors.string());
  return std::system(command.c_str()) == 0 ? std::string() : readFile(errors);
}

// Two samples in two splits, each in a shard of its own.
inline Manifest filledManifest() {
  Manifest m = testManifest();
  m.about = {{"license", "CC-BY-4.0"}, {"creator", "Somebody"}};
  m.shards = {{"train/train-000000.tar", "train", sha256("a"), 12345678901234u, 1},
              {"val/val-000000.tar", "val", sha256("b"), 1024, 1}};
  for (std::uint32_t i = 0; i < 2; ++i) {
    const Sample sample = testSample(m, i, "street-1-drive-00000" + std::to_string(i), i == 0 ? "train" : "val");
    SampleRecord record{sample.key, sample.split, i, sample.scans, {sample.key + ".json"}};
    for (const Member& member : sample.files) record.members.push_back(sample.key + "." + member.suffix);
    for (const std::string& member : record.members) record.xxh3.push_back(xxh3(member));
    m.samples.push_back(record);
  }
  return m;
}

}  // namespace scanmill
