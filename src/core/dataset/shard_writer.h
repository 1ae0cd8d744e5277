#pragma once

// Writes the samples of one shard.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "dataset/manifest.h"

namespace scanmill {

// A tar file in the format POSIX ustar; a name that is too long for ustar gets a pax header. The file contains no times
// and no user names, so that the same members give the same bytes. Only close() gives the file its final name, so that
// a file is never incomplete under that name. All calls throw an Error with the path if the disk fails.
class ShardFile {
 public:
  // Creates the file `path`, which must be below `folder`. Follows no links below `folder` (base/own_folder.h).
  ShardFile(const std::filesystem::path& folder, const std::filesystem::path& path);
  ~ShardFile();
  ShardFile& operator=(ShardFile&&) = delete;  // neither copied nor moved

  // Appends a member.
  void add(const std::string& name, std::string_view bytes);

  struct Digest {
    std::string sha256;
    std::uint64_t bytes = 0;
  };
  // Completes the file and gives it its final name. Returns the file's hash and size.
  Digest close();

  // Returns the number of bytes that add() appends to the file for a member; close() appends kEndBytes.
  static std::uint64_t memberBytes(std::size_t nameLength, std::uint64_t bytes);
  static constexpr std::uint64_t kEndBytes = 1024;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// A file of a sample.
struct Member {
  std::string suffix;  // end of the name, after the key and a dot: "top.ray_tracing.pcd"
  std::string bytes;
};

// A sample to write: a record and files. The writer adds the members' names and hashes to its copy of the record.
struct Sample : SampleRecord {
  std::vector<Member> files;
};

// Returns the number of bytes that the sample takes in its shard, including its description and all headers. A shard
// has ShardFile::kEndBytes more than its samples.
std::uint64_t bytesInShard(const Sample& sample);

// The records of one shard and its samples, for a manifest. SampleRecord::shard is 0 in all of them.
struct ShardPart {
  ShardRecord shard;
  std::vector<SampleRecord> samples;
};

// Writes one shard. The same samples in the same order give the same bytes. Only finish() gives the file its final
// name.
class ShardWriter {
 public:
  // `name`: path relative to the folder, see shardName(). All member functions throw Error if the disk fails.
  ShardWriter(const std::filesystem::path& folder, const std::string& name, const std::string& split);

  // Appends a sample. Throws Error for names that WebDataset would misread, and for a sample of another split than the
  // shard's; further samples can then still be added. After an error of the disk, all calls throw Error.
  void add(const Sample& sample);
  [[nodiscard]] ShardPart finish();

 private:
  ShardPart part_;
  ShardFile file_;
  bool broken_ = false;  // true if a sample was only partly written, so that the shard must not be closed
};

}  // namespace scanmill
