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
  std::string sensor;  // as the manifest writes it, else as the members' names do; empty where they have none
  std::string method;  // as the manifest writes it, else as the members' names do; empty where they have none
  std::vector<std::string> members;    // the names of the shard's members that hold the scan, in the shard's order
  const ScanRecord* record = nullptr;  // the manifest's; null where there is no manifest
};

class ScanStore {
 public:
  // Whether members that are read are compared with the manifest's XXH3, where it states them. Those that differ are
  // refused.
  enum class Digests { Ignored, Compared };

  // Reads the manifest of a dataset, the directory of a shard, a single scan, or the list of the scans in a folder of
  // those layouts that imports/scan_folder.h knows. The manifest of a shard is looked for
  // beside and above it; a shard without one is read, too. Of a shard that was cut short, the members that are whole
  // are read. Throws InputError.
  explicit ScanStore(std::filesystem::path path, Digests digests = Digests::Ignored);
  ScanStore(const ScanStore&) = delete;
  ScanStore& operator=(const ScanStore&) = delete;

  const std::filesystem::path& path() const { return path_; }
  bool single() const { return single_.has_value(); }
  const Manifest* manifest() const { return manifest_.get(); }  // null where there is none
  // The classes of the labels, by the manifest or the layout; null where they are unknown.
  const Ontology* ontology() const;
  std::filesystem::path folder() const { return folder_; }  // the manifest's
  // The beam table of a sensor, with directions filled in; null where it is unknown. Any thread may call it.
  // `time`: of the scan (s), for sensors whose beams differ from one to the next.
  std::shared_ptr<const BeamTable> beams(const std::string& sensor, double time) const;

  // The keys of the samples; of a single scan the name of its file.
  const std::vector<std::string>& keys() const { return keys_; }
  // The index of the sample with this key.
  std::optional<std::size_t> find(const std::string& key) const;
  // The names of all sensors; empty for a single scan.
  std::vector<std::string> sensors() const;

  // The scans of a sample that are in known formats, or those of one sensor. Any thread may call it. Throws InputError,
  // with the sensors that there are, where there is no scan.
  std::vector<StoredScan> scans(std::size_t sample, const std::string& sensor = {}) const;
  // Decodes the first of a scan's members that can be decoded. Any thread may call it. Throws InputError, which says
  // what is wrong with each member, where none can be.
  Scan decode(std::size_t sample, const StoredScan& scan) const;
  // The things near the sensors of a sample; none where the dataset lists no objects. Any thread may call it. Throws
  // InputError where the list is damaged.
  std::optional<SampleObjects> objects(std::size_t sample) const;
  // The bytes of the member with the voxels about a sensor, see dataset/voxels.h; none where the dataset has none. Any
  // thread may call it. Throws InputError where the member is damaged.
  std::optional<std::string> voxels(std::size_t sample, const std::string& sensor) const;
  // What is wrong with the sample's shard, although the sample itself may be whole. Empty where nothing is known to be
  // wrong, and where the shard cannot be opened at all. Any thread may call it.
  std::string damage(std::size_t sample) const;
  // The indices of samples of which nothing can be read, as far as that is known by now, ascending: their shard is
  // missing or is no tar, or they lie behind the place where it was cut. Any thread may call it.
  std::vector<std::size_t> unreadableSamples() const;

 private:
  struct Sample {
    std::size_t shard = 0;
    std::vector<std::string> members;  // only where no manifest lists them
    const SampleRecord* record = nullptr;
  };
  struct Shard {
    std::filesystem::path file;
    std::unique_ptr<const ShardIndex> index;  // null until it is needed
    std::uint64_t bytes = 0;                  // its size by the manifest; 0 where that says nothing
    bool failed = false;                      // it could not be opened when it was last tried
    bool sized = false;                       // its size has been compared with `bytes`
  };

  void openDataset();
  void openShard();
  void openSingle();
  StoredScan scanOfRecorded(std::size_t sample, const std::string& sensor) const;
  void addSample(const std::string& key, Sample sample);
  const std::vector<std::string>& membersOf(const Sample& sample) const;
  const ShardIndex& shard(std::size_t number) const;
  void openIndex(Shard& shard) const;  // the caller holds the lock

  void requireUnchanged(const Sample& sample, const std::string& member, std::string_view bytes) const;

  Digests digests_;
  std::filesystem::path path_;
  std::filesystem::path folder_;
  std::shared_ptr<const Manifest> manifest_;
  std::optional<Scan> single_;
  std::optional<ScanFolder> recorded_;
  std::optional<Ontology> ontology_;  // of recorded scans
  std::vector<std::string> keys_;
  std::vector<Sample> samples_;  // as keys_
  std::unordered_map<std::string, std::size_t> byKey_;
  mutable std::mutex mutex_;  // guards what is made when it is needed
  mutable std::vector<Shard> shards_;
  mutable std::vector<std::shared_ptr<const BeamTable>> beams_;  // one per sensor of the manifest
};

}  // namespace scanmill
