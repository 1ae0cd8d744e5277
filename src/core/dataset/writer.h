#pragma once

// Writes a dataset: samples into tar shards that WebDataset reads, and at last the manifest.

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "dataset/manifest.h"

namespace scanmill {

// A file of a sample.
struct Member {
  std::string suffix;  // "top.ray_tracing.pcd": what follows the sample's key and a dot; lower-case
  std::string bytes;
};

// All scans of a frame.
struct Sample {
  std::string key;
  std::string split;
  std::vector<ScanRecord> scans;
  std::vector<Member> members;
};

// Shards are POSIX ustar files in one folder per split: DIR/train/train-000000.tar. The same samples in the same order
// give the same bytes. A shard has its final name only when it is whole.
class DatasetWriter {
 public:
  // Makes the folder ready by prepareOutputFolder(), which throws an InputError for one that may not be written to.
  // Until finish() there is no manifest, hence nothing that looks finished. A shard is closed before it would exceed
  // `shardBytes`.
  DatasetWriter(std::filesystem::path folder, bool overwrite, std::uint64_t shardBytes);
  ~DatasetWriter();

  // Appends a sample to the open shard of its split. Throws Error where the disk fails.
  void add(const Sample& sample);
  std::uint64_t bytesWritten() const;  // to shards, so far

  // Closes the shards, fills in manifest.shards and manifest.samples, and writes the manifest.
  void finish(Manifest& manifest);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scanmill
