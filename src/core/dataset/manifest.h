#pragma once

// manifest.json: the contents of a dataset and how it was generated. Its JSON Schema is docs/manifest.schema.json.
//
//   const Manifest manifest = readManifest("out/quickstart");
//   for (const SampleRecord& sample : manifest.samples) std::puts(sample.key.c_str());

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/input_budget.h"
#include "base/vec.h"
#include "config/distribution.h"
#include "scan/modelled_item.h"
#include "scan/reasons.h"
#include "scene/ontology.h"
#include "sensors/beams.h"

namespace scanmill {

// A file that a dataset was made from.
struct FileRecord {
  std::string file;  // path, as savedPath() gives it
  std::string xxh3;  // hash of the file's bytes
  auto operator<=>(const FileRecord&) const = default;
};

// Returns the records of all files in `read`, sorted. `folder`: folder of the pipeline file, for savedPath().
std::vector<FileRecord> recordsOf(const FilesRead& read, const std::filesystem::path& folder);

// Adds records to a list, which is then sorted and without duplicates. Returns the first file in the list that has two
// different hashes; empty if there is none.
std::string addFiles(const std::vector<FileRecord>& added, std::vector<FileRecord>& files);

// Throws an InputError that begins with `dataset` if any of the files is missing or changed. `folder`: see recordsOf().
void requireUnchangedFiles(const std::vector<FileRecord>& files, const std::filesystem::path& folder,
                           const std::filesystem::path& dataset);

struct SensorRecord {
  std::string name;                       // name of the sensor on the vehicle
  BeamTable beams;                        // only the compact description, without the tables per beam
  std::optional<Pose> vehicleFromSensor;  // not set if the mount is random: each scan then states its own
  std::string choice = {};                // each sequence has one of the sensors with this text; empty: all have it
  double intensityFullScale = 1;          // the value of the column intensity that stands for 1, such as 255 for bytes
};

// One scan: a revolution of a sensor in a sample.
struct ScanRecord {
  std::string sensor;
  std::uint32_t revolution = 0;  // index among the sensor's revolutions in the sample
  std::string method;
  double time = 0;                             // s since the start of the sequence
  std::optional<Pose> vehicleFromSensor = {};  // set only if the mount is random
  std::vector<Pose> worldFromSensor;  // poses at the first and, if the sensor moves, at the last step of the revolution
  std::uint64_t beams = 0;
  std::uint64_t points = 0;
  std::uint64_t unresolved = 0;  // beams that the method could not trace: neither hit nor miss
  std::map<std::uint16_t, std::uint64_t> pointsPerClass{};
  std::uint32_t instances = 0;  // number of object instances with points
  ReasonCounts beamsPerReason;  // reasons of all beams; empty if the pipeline does not ask for reasons
};

// Returns the pose at which the sensor of a scan is mounted on the vehicle.
inline const Pose& mountOf(const SensorRecord& sensor, const ScanRecord& scan) {
  return scan.vehicleFromSensor ? *scan.vehicleFromSensor : sensor.vehicleFromSensor.value();
}

// Returns the part of a member's name after the sample's key and the dot, such as "top.ray_tracing.pcd", or
// "top.1.ray_tracing.pcd" for the sensor's second revolution. All letters are converted to lower case.
std::string memberSuffix(const ScanRecord& scan, std::string_view formatSuffix);
// Returns the beginning of memberSuffix(), up to the method: "top", or "top.1" for the second revolution.
std::string revolutionName(const ScanRecord& scan);

// Counts of the object instances of one class near the sensors of a sample.
struct ObjectCount {
  std::uint64_t objects = 0;
  std::uint64_t withPoints = 0;  // instances with points in at least one of the sample's scans
  bool operator==(const ObjectCount&) const = default;
};

struct SampleRecord {
  std::string key;  // scene-seed-trajectory-frame, without dots
  std::string split;
  std::uint32_t shard = 0;  // index into Manifest::shards
  std::vector<ScanRecord> scans = {};
  std::vector<std::string> members = {};  // names of the members in the shard, in order
  std::vector<std::string> xxh3 = {};     // hash of each member's bytes
  // Returns the hash of the member's bytes; empty if the record does not list the member.
  std::string xxh3Of(const std::string& member) const;
  // Counts of the objects in the member `<key>.objects.json`, by class; nothing if the pipeline does not ask for
  // objects.
  std::optional<std::map<std::uint16_t, ObjectCount>> objects = {};
  std::vector<DrawnValue> draws = {};  // random values chosen for keys in the scene file and the pipeline
  // Time of the frame (s since the start of the sequence); not set if the first scan starts at this time.
  std::optional<double> time = {};
};

struct ShardRecord {
  std::string file;  // path relative to the manifest
  std::string split;
  std::string sha256;
  std::uint64_t bytes = 0;
  std::uint64_t samples = 0;
  // Hash of the file that describes the shard's samples, see samplesFileOf(); empty if the manifest itself describes
  // them.
  std::string samplesSha256 = {};
};

struct FormatRecord {
  std::string name;
  std::string suffix;
  double maxErrorMetres = 0;
};

// The frames of one drive through a scene. Paths of files are as savedPath() gives them (config/resources.h).
struct SequenceRecord {
  std::string name;       // the key of its samples without the frame: "street-s1-lane"
  std::string scene;      // "street"
  std::string sceneFile;  // path of the scene file; empty if the scans come from a recording
  std::uint64_t seed = 1;
  std::string trajectory;
  bool moving = true;   // false: objects stay at their positions at time 0 s
  std::string vehicle;  // path of the ego vehicle's scene file; empty: none
  bool operator==(const SequenceRecord&) const = default;
};

struct Manifest {
  static constexpr int kSchemaVersion = 3;
  std::string programVersion;
  std::string name;
  std::map<std::string, std::string> about;  // texts of the pipeline's key `about`, by their keys
  std::string pipelineText;                  // text of the pipeline, with the overrides of --set appended as comments
  std::string pipelineSha256;
  std::string planSha256;  // see datasetPlan()
  std::uint64_t seed = 0;
  bool organised = false;
  bool deskewed = false;
  std::vector<std::string> columns;  // columns of every scan
  // Ids of the classes whose objects the samples list; empty if they list the objects of all classes, or none.
  std::vector<std::uint16_t> objectClasses = {};
  std::vector<FormatRecord> formats;
  Ontology ontology;
  std::vector<SensorRecord> sensors;
  std::vector<SequenceRecord> sequences;
  // Files that the scenes and trajectories were read from, sorted. A file has several entries if it changed while the
  // dataset was made, and the user allowed the change.
  std::vector<FileRecord> files;
  std::vector<ModelledItem> modelled;  // features that are modelled or left out
  std::vector<ShardRecord> shards;
  std::vector<SampleRecord> samples;

  // Returns true if the scans have the column.
  bool hasColumn(std::string_view column) const { return std::ranges::find(columns, column) != columns.end(); }
  // Returns the record of a sample's sequence; null if there is none.
  const SequenceRecord* sequenceOf(const std::string& key) const;
};

// Returns the name of the file beside a shard that describes the shard's samples in a large dataset, such as
// "train/train-000000.json".
std::string samplesFileOf(const std::string& shardFile);
// Returns the text of the file that samplesFileOf() names. `shard`: index of the shard. `numbers`: indices of its
// samples in `manifest`, in the order in which the samples are written.
std::string samplesJson(const Manifest& manifest, std::uint32_t shard, const std::vector<std::uint64_t>& numbers);

// Returns the text of the member `<key>.json`, which is the first member of each sample in a shard: key, sequence,
// frame, split, time of the frame (s), the poses and counts of the scans, and the random values. Class ids refer to the
// manifest's ontology. The record's shard, members and counts of objects are left out.
std::string sampleJson(const SampleRecord& sample);
// Returns the first difference between a member's text and the record ("/scans/0/points is 11, not 12"), or a message
// that the text is not JSON. Empty if text and record agree.
std::string differenceOfSampleJson(std::string_view text, const SampleRecord& sample);

// Returns the text of the manifest, without samples that other files describe. Its last key, `digest`, is the SHA-256
// of the complete text with 64 zeros in place of the digest.
std::string toJson(const Manifest& manifest);
// Returns the problem with the digest in a manifest's text: the digest is missing or does not match. Empty if it
// matches.
[[nodiscard]] std::string digestProblem(std::string text);
// Throws InputError if the text of the manifest `file` states a digest that does not match the text.
void requireStatedDigest(const std::filesystem::path& file, const std::string& text);
// Parses a manifest. Throws an InputError that names `file`, the place in the text, and the problem.
Manifest parseManifest(const std::string& text, const std::string& file);
// Reads manifest.json in a dataset's folder, and also the files beside the shards if they describe the samples. Throws
// InputError.
Manifest readManifest(const std::filesystem::path& folder);
// Reads manifest.json like the function above, but accepts missing or damaged files beside the shards: for each such
// file, sets undescribed[index of the shard] to a message that begins with the file's path. The samples of this shard
// have empty keys.
Manifest readManifest(const std::filesystem::path& folder, std::map<std::uint32_t, std::string>& undescribed);

}  // namespace scanmill
