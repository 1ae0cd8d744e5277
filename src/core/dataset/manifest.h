#pragma once

// manifest.json: what a dataset holds and how it was made. Its JSON Schema is docs/manifest.schema.json.

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/vec.h"
#include "config/distribution.h"
#include "scan/reasons.h"
#include "scene/ontology.h"
#include "sensors/beams.h"

namespace scanmill {

struct SensorRecord {
  std::string name;  // on the vehicle
  BeamTable beams;   // without its tables per beam: the manifest has the compact description
  Pose vehicleFromSensor;
  double intensityFullScale = 1;  // what stands for 1 in the column intensity: 255 where it has bytes
};

// One scan: a revolution of a sensor in a sample.
struct ScanRecord {
  std::string sensor;
  std::string method;
  double time = 0;                             // s since the start of the sequence
  std::optional<Pose> vehicleFromSensor = {};  // where that differs from sequence to sequence
  std::vector<Pose> worldFromSensor;  // at the start of the revolution, and of its last step where the sensor moves
  std::uint64_t beams = 0;
  std::uint64_t points = 0;
  std::uint64_t unresolved = 0;  // beams that the method gave up: neither hit nor miss
  std::map<std::uint16_t, std::uint64_t> pointsPerClass;
  std::uint32_t instances = 0;  // distinct, in view
  ReasonCounts beamsPerReason;  // of all beams; empty where the pipeline does not ask for reasons
};

// Where the sensor of a scan was mounted.
inline const Pose& mountOf(const SensorRecord& sensor, const ScanRecord& scan) {
  return scan.vehicleFromSensor ? *scan.vehicleFromSensor : sensor.vehicleFromSensor;
}

// What stands behind the sample's key and a dot in the name of a scan's member in one format: "top.ray_tracing.pcd", in
// lower case.
std::string memberSuffix(const ScanRecord& scan, std::string_view formatSuffix);

// Of the things near the sensors of a sample, of one class.
struct ObjectCount {
  std::uint64_t objects = 0;
  std::uint64_t withPoints = 0;  // in any of the sample's scans
  bool operator==(const ObjectCount&) const = default;
};

struct SampleRecord {
  std::string key;  // scene-seed-trajectory-frame, no dots
  std::string split;
  std::uint32_t shard = 0;  // index into Manifest::shards
  std::vector<ScanRecord> scans;
  std::vector<std::string> members;    // names in the shard, in order
  std::vector<std::string> xxh3 = {};  // of each member's bytes; empty in earlier manifests
  // By class, of what the member `<key>.objects.json` lists; none where the pipeline asks for no objects.
  std::optional<std::map<std::uint16_t, ObjectCount>> objects = {};
  std::vector<DrawnValue> draws = {};  // for keys of the scene's file and of the pipeline
};

struct ShardRecord {
  std::string file;  // relative to the manifest
  std::string split;
  std::string sha256;
  std::uint64_t bytes = 0;
  std::uint64_t samples = 0;
  // Of the file that describes the shard's samples, see samplesFileOf(); empty where the manifest itself does.
  std::string samplesSha256 = {};
};

struct FormatRecord {
  std::string name;
  std::string suffix;
  double maxErrorMetres = 0;
};

// Which setting `method: auto` has chosen, and why.
struct MethodRecord {
  std::string setting;     // "depth_camera resolution=1024"
  std::string assignment;  // for --set, to take the same again: "method={depth_camera: {resolution: 1024}}"
  std::string why;
  bool operator==(const MethodRecord&) const = default;
};

struct Manifest {
  static constexpr int kSchemaVersion = 2;  // 1 is written where the manifest itself describes the samples
  std::string programVersion;
  std::string name;
  std::string pipelineText;  // with the overrides applied
  std::string pipelineSha256;
  std::string planSha256;  // see datasetPlan(); empty in earlier manifests
  std::uint64_t seed = 0;
  bool organised = false;
  bool deskewed = false;
  std::vector<std::string> columns;  // of every scan
  std::vector<FormatRecord> formats;
  Ontology ontology;
  std::vector<SensorRecord> sensors;
  std::vector<std::string> modelled;   // what was modelled and what was left out, one line each
  std::optional<MethodRecord> chosen;  // where the pipeline left the choice of the method
  std::vector<ShardRecord> shards;
  std::vector<SampleRecord> samples;
};

// The samples of a large dataset are described in a file beside each shard: train/train-000000.json.
std::string samplesFileOf(const std::string& shardFile);
// The text of that file. `numbers`: of the shard's samples in the manifest, in order.
std::string samplesJson(const Manifest& manifest, std::uint32_t shard, const std::vector<std::uint64_t>& numbers);

// Without the samples that have files of their own. Its last key, `digest`, is the SHA-256 of the whole text with 64
// zeros in the digest's own place.
std::string toJson(const Manifest& manifest);
// Says that a manifest's text does not have the digest that it states, or states none; empty where it has it.
std::string digestProblem(std::string text);
// Throws an InputError that names `file`, the place in it, and what is wrong there.
Manifest parseManifest(const std::string& text, const std::string& file);
// Reads the file manifest.json of a dataset's folder, and the files that describe the samples where there are such.
// Throws InputError.
Manifest readManifest(const std::filesystem::path& folder);

}  // namespace scanmill
