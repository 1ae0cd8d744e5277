#pragma once

// Reads scans from a dataset's folder, a shard, the file of one scan, or a folder of recorded scans.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "dataset/manifest.h"
#include "dataset/objects.h"
#include "dataset/reader.h"
#include "imports/scan_folder.h"
#include "scan/scan.h"

namespace scanmill {

// One scan of a sample, in all formats in which it was written.
struct StoredScan {
  std::string sensor;                // from the manifest or, if there is none, from the members' names; empty: unknown
  std::uint32_t revolution = 0;      // index among the sensor's revolutions in the sample
  std::string method;                // from the manifest or, if there is none, from the members' names; empty: unknown
  std::vector<std::string> members;  // members of the shard with this scan, sorted by the errors of their formats if
                                     // there is a manifest; for a recorded scan, its file
  const ScanRecord* record = nullptr;  // record in the manifest; null: there is no manifest
};

// All functions may be called from any thread.
class ScanStore {
 public:
  // Compared: the bytes of a member are compared with the XXH3 that the manifest states for it, if any, and reading a
  // member that differs throws an InputError.
  enum class Digests { Ignored, Compared };

  // Reads the manifest of a dataset, the headers of a shard, a single scan, or the list of scans in a folder whose
  // layout imports/scan_folder.h supports. The manifest of a shard is searched beside and above the shard; a shard
  // without a manifest can also be read. If a shard is truncated, its complete members can be read. Throws InputError.
  explicit ScanStore(std::filesystem::path path, Digests digests = Digests::Ignored);
  ScanStore& operator=(ScanStore&&) = delete;  // neither copied nor moved

  const std::filesystem::path& path() const { return path_; }
  bool single() const { return single_.has_value(); }
  const Manifest* manifest() const { return manifest_.get(); }  // null: the scans have no manifest
  // Returns the classes of the labels, from the manifest or the layout; null if they are unknown.
  const Ontology* ontology() const;
  // Returns the azimuth (rad) of the vehicle's heading in the frame of the scans of a sensor that looks ahead.
  double heading() const { return recorded_ ? recorded_->heading : 0; }
  std::filesystem::path folder() const { return folder_; }  // folder of the manifest
  // Returns the beam table of a sensor, filled by fillBeams() if it has at most 2^23 beams; null if the sensor's beams
  // are unknown. `time`: time of the scan (s), for sensors whose beams differ from scan to scan.
  std::shared_ptr<const BeamTable> beams(const std::string& sensor, double time) const;

  // Returns the keys of all samples; for a single scan, the name of its file.
  const std::vector<std::string>& keys() const { return keys_; }
  // Returns the index of the sample with this key; nothing if there is none.
  std::optional<std::size_t> find(const std::string& key) const;
  // Returns the names of all sensors; none for a single scan.
  std::vector<std::string> sensors() const;

  // Returns the scans of a sample by `sensor` (empty: by all sensors) that have a known format; the revolutions of a
  // sensor are in order. If there is no such scan, throws an InputError that lists the sample's sensors.
  std::vector<StoredScan> scans(std::size_t sample, const std::string& sensor = {}) const;
  // Decodes a scan from the first of its members that can be decoded. If no member can be decoded, throws an InputError
  // with the problem of each member.
  Scan decode(std::size_t sample, const StoredScan& scan) const;
  // Returns the object instances near the sensors of a sample; nothing if the dataset lists no objects. Throws
  // InputError if the list is damaged.
  std::optional<SampleObjects> objects(std::size_t sample) const;
  // Returns the bytes of the member with the voxels around a sensor, see dataset/voxels.h; nothing if the dataset has
  // no voxels. Throws InputError if the member is damaged.
  std::optional<std::string> voxels(std::size_t sample, const std::string& sensor) const;
  // Returns the known damage of the sample's shard, even if the sample itself is intact. Empty if no damage is known,
  // or if the shard cannot be opened at all.
  [[nodiscard]] std::string damage(std::size_t sample) const;

 private:
  struct Sample {
    std::size_t shard = 0;
    std::vector<std::string> members;  // names of the members; if empty, `record` lists them
    const SampleRecord* record = nullptr;
  };
  struct Shard {
    std::filesystem::path file;
    std::unique_ptr<const ShardIndex> index;  // null until the index is needed
  };

  void openDataset();
  void openShard();
  void openSingle();
  // Returns the scans of all sensors in a sample of a dataset or shard.
  std::vector<StoredScan> scansInShard(const Sample& sample) const;
  void addSample(const std::string& key, Sample sample);
  const ShardIndex& shard(std::size_t number) const;

  // Returns the bytes of a member of a sample's shard; nothing if the shard does not have it. Throws InputError if they
  // differ from their hash in the manifest, unless Digests::Ignored.
  std::optional<std::string> bytesOf(std::size_t sample, const std::string& name) const;

  Digests digests_;
  std::filesystem::path path_;
  std::filesystem::path folder_;              // folder of the manifest; empty: there is no manifest
  std::shared_ptr<const Manifest> manifest_;  // of a dataset or a shard; null: there is no manifest
  std::optional<Scan> single_;                // set only if the file of one scan is read
  std::optional<ScanFolder> recorded_;        // set only if a folder of recorded scans is read
  std::optional<Ontology> ontology_;          // classes of scans that were recorded or are single files
  std::vector<std::string> keys_;
  std::vector<Sample> samples_;  // one per key, in the order of keys_
  std::unordered_map<std::string, std::size_t> byKey_;
  mutable std::mutex mutex_;  // guards shards_ and beams_, whose items are created on first use
  mutable std::vector<Shard> shards_;
  mutable std::vector<std::shared_ptr<const BeamTable>> beams_;  // one per sensor of the manifest
};

// A decoded scan, with what is known about its sensor and its classes.
struct ScanSource {
  Scan scan;
  std::string title;                       // for example "street-s1-lane-000010, top"
  std::shared_ptr<const BeamTable> beams;  // beam table of the sensor; null if unknown
  std::optional<Ontology> ontology;        // from the dataset's manifest or the folder's layout; none: unknown classes
};

// Finds and decodes a scan. `path`: see ScanStore. `sensor`: name of a sensor; if empty, the first sensor. `sample`:
// see findKey(); if empty, the middle sample or, if it lacks a scan of the sensor, the next sample that has one. Throws
// InputError, for example if `path` is the file of a single scan and `sample` or `sensor` is not empty.
ScanSource findScan(const std::filesystem::path& path, const std::string& sample, const std::string& sensor);

}  // namespace scanmill
