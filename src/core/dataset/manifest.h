#pragma once

// manifest.json: the contents of a dataset and how it was generated. Its JSON Schema is docs/manifest.schema.json.
//
//   const Manifest manifest = readManifest("out/quickstart");
//   for (const SampleRecord& sample : manifest.samples) std::puts(sample.key.c_str());

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
  BeamTable beams;   // only the compact description, without the tables per beam
  Pose vehicleFromSensor;
  double intensityFullScale = 1;  // the value of the column intensity that means 1: 255 if the column has bytes
};

// One scan: a revolution of a sensor in a sample.
struct ScanRecord {
  std::string sensor;
  std::string method;
  double time = 0;                             // s since the start of the sequence
  std::optional<Pose> vehicleFromSensor = {};  // set only if the mount differs from sequence to sequence
  std::vector<Pose> worldFromSensor;  // at the start of the revolution and, if the sensor moves, of its last step
  std::uint64_t beams = 0;
  std::uint64_t points = 0;
  std::uint64_t unresolved = 0;  // beams that the method gave up: neither hit nor miss
  std::map<std::uint16_t, std::uint64_t> pointsPerClass;
  std::uint32_t instances = 0;  // number of object instances with points
  ReasonCounts beamsPerReason;  // reasons of all beams; empty if the pipeline does not ask for reasons
};

// Returns the pose at which the sensor of a scan was mounted.
inline const Pose& mountOf(const SensorRecord& sensor, const ScanRecord& scan) {
  return scan.vehicleFromSensor ? *scan.vehicleFromSensor : sensor.vehicleFromSensor;
}

// Returns the part of the name of a scan's member that follows the sample's key and a dot, in lower case:
// "top.ray_tracing.pcd".
std::string memberSuffix(const ScanRecord& scan, std::string_view formatSuffix);

// Counts of the object instances of one class near the sensors of a sample.
struct ObjectCount {
  std::uint64_t objects = 0;
  std::uint64_t withPoints = 0;  // those with points in any of the sample's scans
  bool operator==(const ObjectCount&) const = default;
};

struct SampleRecord {
  std::string key;  // scene-seed-trajectory-frame, no dots
  std::string split;
  std::uint32_t shard = 0;  // index into Manifest::shards
  std::vector<ScanRecord> scans;
  std::vector<std::string> members;    // names in the shard, in order
  std::vector<std::string> xxh3 = {};  // XXH3 of each member's bytes; empty in earlier manifests
  // Counts of the objects in the member `<key>.objects.json`, by class; none if the pipeline does not ask for objects.
  std::optional<std::map<std::uint16_t, ObjectCount>> objects = {};
  std::vector<DrawnValue> draws = {};  // random values of keys in the scene file and the pipeline
};

struct ShardRecord {
  std::string file;  // relative to the manifest
  std::string split;
  std::string sha256;
  std::uint64_t bytes = 0;
  std::uint64_t samples = 0;
  // Hash of the file that describes the shard's samples, see samplesFileOf(); empty if the manifest describes them.
  std::string samplesSha256 = {};
};

struct FormatRecord {
  std::string name;
  std::string suffix;
  double maxErrorMetres = 0;
};

// The setting that `method: auto` has chosen, and why.
struct MethodRecord {
  std::string setting;     // "depth_camera resolution=1024"
  std::string assignment;  // for --set, to choose the setting again: "method={depth_camera: {resolution: 1024}}"
  std::string why;
  bool operator==(const MethodRecord&) const = default;
};

struct Manifest {
  static constexpr int kSchemaVersion = 2;  // 1 is written if the manifest itself describes the samples
  std::string programVersion;
  std::string name;
  std::string pipelineText;  // with the overrides applied
  std::string pipelineSha256;
  std::string planSha256;  // see datasetPlan(); empty in earlier manifests
  std::uint64_t seed = 0;
  bool organised = false;
  bool deskewed = false;
  std::vector<std::string> columns;  // names of the columns that every scan has
  std::vector<FormatRecord> formats;
  Ontology ontology;
  std::vector<SensorRecord> sensors;
  std::vector<std::string> modelled;   // what was modelled and what was left out, one line each
  std::optional<MethodRecord> chosen;  // set if the pipeline says `method: auto`
  std::vector<ShardRecord> shards;
  std::vector<SampleRecord> samples;
};

// Returns the name of the file beside a shard that describes its samples in a large dataset: train/train-000000.json.
std::string samplesFileOf(const std::string& shardFile);
// Returns the text of this file. `numbers`: the indices of the shard's samples in the manifest, in order.
std::string samplesJson(const Manifest& manifest, std::uint32_t shard, const std::vector<std::uint64_t>& numbers);

// Returns the text of the manifest, without samples that are described in other files. Its last key, `digest`, is the
// SHA-256 of the complete text with 64 zeros in place of the digest.
std::string toJson(const Manifest& manifest);
// Returns what is wrong with the digest in a manifest's text: it is missing or does not match; empty if it matches.
std::string digestProblem(std::string text);
// Throws an InputError that names `file`, the place in it, and what is wrong there.
Manifest parseManifest(const std::string& text, const std::string& file);
// Reads manifest.json in a dataset's folder, and the files beside the shards if these describe the samples. Throws
// InputError.
Manifest readManifest(const std::filesystem::path& folder);

}  // namespace scanmill
