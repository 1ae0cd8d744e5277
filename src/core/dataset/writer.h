#pragma once

// Writes samples into tar shards that WebDataset reads, then the manifest.

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "dataset/manifest.h"

namespace scanmill {

struct Member {
  std::string suffix;  // "top.ray_tracing.pcd": all after the sample's key and a dot; lower-case
  std::string bytes;
};

struct Sample {
  std::string key;
  std::string split;
  std::vector<ScanRecord> scans;
  std::vector<Member> members;
};

// Shards are POSIX ustar files, one folder per split: DIR/train/train-000000.tar. The same samples in the same order
// give the same bytes (no clocks, no user names). A shard has its final name only when it is whole.
class DatasetWriter {
 public:
  // Creates `folder`. An existing non-empty folder is an InputError, unless `overwrite`: then what an earlier run of
  // this program wrote there (manifest and shards) is removed first, and nothing else. While the run lasts there is no
  // manifest, hence nothing that looks finished.
  DatasetWriter(std::filesystem::path folder, bool overwrite, std::uint64_t shardBytes);
  ~DatasetWriter();

  // Samples of one split are appended to its open shard; a shard that would exceed shardBytes is closed first.
  void add(const Sample& sample);
  std::uint64_t bytesWritten() const;

  // Closes the shards and writes the manifest last. Fills manifest.shards and manifest.samples.
  void finish(Manifest& manifest);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
