#pragma once

// Writes the samples of one shard.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "dataset/shard.h"

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
  // See SampleRecord.
  std::optional<std::map<std::uint16_t, ObjectCount>> objects = {};
  std::vector<DrawnValue> draws = {};
};

// Returns how many bytes the sample takes in its shard, including its description and all headers.
std::uint64_t bytesInShard(const Sample& sample);

// The records of one shard and its samples for a manifest (SampleRecord::shard is 0).
struct ShardPart {
  ShardRecord shard;
  std::vector<SampleRecord> samples;
};

// The same samples in the same order give the same bytes. Only finish() gives the file its final name.
class ShardWriter {
 public:
  // `name`: relative to the folder, see shardName(). Like all calls, throws Error if the disk fails.
  ShardWriter(const std::filesystem::path& folder, const std::string& name, const std::string& split);

  // Throws Error for names that readers of WebDataset would misread. After any other failure nothing more can be added.
  void add(const Sample& sample);
  std::uint64_t bytes() const { return bytes_; }  // size of the file if finished now
  [[nodiscard]] ShardPart finish();

 private:
  ShardPart part_;
  ShardFile file_;
  std::uint64_t bytes_ = ShardFile::kEndBytes;
  bool broken_ = false;  // a sample was only partly written: the shard must not be closed
};

}  // namespace scanmill
