#pragma once

// Scans on disk: a dataset's folder, a shard, or the file of one scan.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "dataset/manifest.h"
#include "dataset/shard_index.h"
#include "scan/scan.h"

namespace scanmill {

// One scan of a sample, in all the formats that it was written in.
struct StoredScan {
  std::string sensor;  // as the manifest writes it, else as the members' names do; empty where they have none
  std::string method;  // likewise
  std::vector<std::string> members;    // of the shard, in its order
  const ScanRecord* record = nullptr;  // of the manifest; null where there is none
};

class ScanStore {
 public:
  // Reads the manifest of a dataset, the directory of a shard, or a single scan. A shard finds its manifest beside or
  // above it, and does without. Of a shard that was cut short, what is whole counts. Throws InputError.
  explicit ScanStore(std::filesystem::path path);
  ScanStore(const ScanStore&) = delete;
  ScanStore& operator=(const ScanStore&) = delete;

  const std::filesystem::path& path() const { return path_; }
  bool single() const { return single_.has_value(); }
  const Manifest* manifest() const { return manifest_.get(); }  // null where there is none
  std::filesystem::path folder() const { return folder_; }      // of the manifest
  // Of the sensor on the vehicle, filled; null where unknown. From any thread.
  std::shared_ptr<const BeamTable> beams(const std::string& sensor) const;

  // Of the samples; of a single scan, its file's name.
  const std::vector<std::string>& keys() const { return keys_; }
  std::optional<std::size_t> find(const std::string& key) const;
  // Names of all that there are; empty for a single scan.
  std::vector<std::string> sensors() const;

  // The scans of a sample in known formats; with a sensor, only its. From any thread. Throws InputError where there is
  // none, with the sensors that there are.
  std::vector<StoredScan> scans(std::size_t sample, const std::string& sensor = {}) const;
  // By the first of its members that can be decoded. From any thread. Throws InputError that says what is wrong with
  // each.
  Scan decode(std::size_t sample, const StoredScan& scan) const;
  // What is wrong with the sample's shard, of which it may still be a whole part; empty: nothing is known, or it cannot
  // be opened at all. From any thread.
  std::string damage(std::size_t sample) const;
  // Samples of which nothing can be read, as far as that is known by now: their shard is missing or no tar, or they lie
  // behind the place where it was cut. Ascending. From any thread.
  std::vector<std::size_t> lost() const;

 private:
  struct Sample {
    std::size_t shard = 0;
    std::vector<std::string> members;  // where no manifest lists them
    const SampleRecord* record = nullptr;
  };
  struct Shard {
    std::filesystem::path file;
    std::unique_ptr<const ShardIndex> index;  // once it is needed
    std::uint64_t bytes = 0;                  // that the manifest says; 0: it says nothing
    bool failed = false;                      // it could not be opened when it was last tried
    bool sized = false;                       // its size has been compared with that
  };

  void openDataset();
  void openShard();
  void openSingle(const std::string& suffix);
  void addSample(const std::string& key, Sample sample);
  const std::vector<std::string>& membersOf(const Sample& sample) const;
  const ShardIndex& shard(std::size_t number) const;
  void openIndex(Shard& shard) const;  // with the lock

  std::filesystem::path path_;
  std::filesystem::path folder_;
  std::shared_ptr<const Manifest> manifest_;
  std::optional<Scan> single_;
  std::vector<std::string> keys_;
  std::vector<Sample> samples_;  // as keys_
  std::unordered_map<std::string, std::size_t> byKey_;
  mutable std::mutex mutex_;  // of what is made when it is needed
  mutable std::vector<Shard> shards_;
  mutable std::vector<std::shared_ptr<const BeamTable>> beams_;  // as the manifest's sensors
};

}  // namespace scanmill
