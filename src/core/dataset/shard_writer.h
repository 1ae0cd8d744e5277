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

// The bytes that the sample takes in its shard, descriptions and headers included.
std::uint64_t bytesInShard(const Sample& sample);

// What a manifest says of one shard and its samples (SampleRecord::shard is 0).
struct ShardPart {
  ShardRecord shard;
  std::vector<SampleRecord> samples;
};

// The same samples in the same order give the same bytes. The file gets its final name by finish() alone.
class ShardWriter {
 public:
  // `name`: relative to the folder, see shardName(). Throws Error where the disk fails, as all calls do.
  ShardWriter(const std::filesystem::path& folder, const std::string& name, const std::string& split);

  // Throws Error for names that readers of WebDataset would misread. After any other failure nothing can be added any
  // more.
  void add(const Sample& sample);
  std::uint64_t bytes() const { return bytes_; }  // that the file will have
  ShardPart finish();

 private:
  ShardPart part_;
  ShardFile file_;
  std::uint64_t bytes_ = ShardFile::kEndBytes;
  bool broken_ = false;  // a sample was written in part: the shard may not be closed any more
};

}  // namespace scanmill
