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
#include "dataset/shard_index.h"
#include "imports/scan_folder.h"
#include "scan/scan.h"

namespace scanmill {

// One scan of a sample, in all the formats that it was written in.
struct StoredScan {
  std::string sensor;                  // as in the manifest, else as in the members' names; empty: unknown
  std::string method;                  // as in the manifest, else as in the members' names; empty: unknown
  std::vector<std::string> members;    // the names of the shard's members that hold the scan, in the shard's order
  const ScanRecord* record = nullptr;  // in the manifest; null: there is no manifest
};

class ScanStore {
 public:
  // Whether members are compared with their XXH3 in the manifest when they are read, if it has any. Reading a member
  // that differs throws.
  enum class Digests { Ignored, Compared };

  // Reads the manifest of a dataset, the headers of a shard, a single scan, or the list of scans in a folder with a
  // layout that imports/scan_folder.h knows. The manifest of a shard is searched beside and above it; a shard without a
  // manifest can be read, too. The complete members of a truncated shard can be read. Throws InputError.
  explicit ScanStore(std::filesystem::path path, Digests digests = Digests::Ignored);
  ScanStore(const ScanStore&) = delete;
  ScanStore& operator=(const ScanStore&) = delete;

  const std::filesystem::path& path() const { return path_; }
  bool single() const { return single_.has_value(); }
  const Manifest* manifest() const { return manifest_.get(); }  // null: there is none
  // Returns the classes of the labels, from the manifest or the layout; null if they are unknown.
  const Ontology* ontology() const;
  std::filesystem::path folder() const { return folder_; }  // of the manifest
  // Returns the beam table of a sensor, with directions filled in; null if it is unknown. `time` is that of the scan
  // (s), for sensors whose beams differ from scan to scan. Any thread may call it.
  std::shared_ptr<const BeamTable> beams(const std::string& sensor, double time) const;

  // Returns the keys of the samples; for a single scan the name of its file.
  const std::vector<std::string>& keys() const { return keys_; }
  // Returns the index of the sample with this key.
  std::optional<std::size_t> find(const std::string& key) const;
  // Returns the names of all sensors; empty for a single scan.
  std::vector<std::string> sensors() const;

  // Returns the scans of a sample that are in known formats: those of one sensor, or all if `sensor` is empty. Any
  // thread may call it. Throws InputError if there is no such scan, with the sensors that the sample has.
  std::vector<StoredScan> scans(std::size_t sample, const std::string& sensor = {}) const;
  // Decodes a scan from the first of its members that can be decoded. Any thread may call it. If there is none, throws
  // an InputError that says what is wrong with each member.
  Scan decode(std::size_t sample, const StoredScan& scan) const;
  // Returns the object instances near the sensors of a sample; none if the dataset lists no objects. Any thread may
  // call it. Throws InputError if the list is damaged.
  std::optional<SampleObjects> objects(std::size_t sample) const;
  // Returns the bytes of the member with the voxels around a sensor, see dataset/voxels.h; none if the dataset has no
  // voxels. Any thread may call it. Throws InputError if the member is damaged.
  std::optional<std::string> voxels(std::size_t sample, const std::string& sensor) const;
  // Returns what is wrong with the sample's shard, even if the sample itself is intact. Empty if nothing is known to be
  // wrong, or if the shard cannot be opened at all. Any thread may call it.
  std::string damage(std::size_t sample) const;
  // Returns the indices of samples known by now to be unreadable, ascending: their shard is missing, is not a tar file,
  // or was truncated before them. Any thread may call it.
  std::vector<std::size_t> unreadableSamples() const;

 private:
  struct Sample {
    std::size_t shard = 0;
    std::vector<std::string> members;  // empty if a manifest lists them
    const SampleRecord* record = nullptr;
  };
  struct Shard {
    std::filesystem::path file;
    std::unique_ptr<const ShardIndex> index;  // null until it is needed
    std::uint64_t bytes = 0;                  // the shard's size in the manifest; 0: unknown
    bool failed = false;                      // the last attempt to open it has failed
    bool sized = false;                       // the shard's size has been compared with `bytes`
  };

  void openDataset();
  void openShard();
  void openSingle();
  StoredScan scanOfRecorded(std::size_t sample, const std::string& sensor) const;
  void addSample(const std::string& key, Sample sample);
  const std::vector<std::string>& membersOf(const Sample& sample) const;
  const ShardIndex& shard(std::size_t number) const;
  void openIndex(Shard& shard) const;  // the caller must have locked mutex_

  void requireUnchanged(const Sample& sample, const std::string& member, std::string_view bytes) const;

  Digests digests_;
  std::filesystem::path path_;
  std::filesystem::path folder_;
  std::shared_ptr<const Manifest> manifest_;
  std::optional<Scan> single_;
  std::optional<ScanFolder> recorded_;
  std::optional<Ontology> ontology_;  // classes of scans that were recorded or are single files
  std::vector<std::string> keys_;
  std::vector<Sample> samples_;  // in the order of keys_
  std::unordered_map<std::string, std::size_t> byKey_;
  mutable std::mutex mutex_;  // guards shards_ and beams_, which are filled when they are needed
  mutable std::vector<Shard> shards_;
  mutable std::vector<std::shared_ptr<const BeamTable>> beams_;  // one per sensor of the manifest
};

}  // namespace scanmill
