#include "dataset/writer.h"

#include <fmt/core.h>

#include <algorithm>
#include <set>
#include <unordered_set>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "dataset/output_folder.h"
#include "dataset/sample_json.h"
#include "dataset/shard.h"
#include "dataset/shard_name.h"

namespace scanmill {

namespace {

constexpr std::string_view kJsonSuffix = "json";

[[noreturn]] void refuse(const Sample& sample, const std::string& why) {
  throw Error(fmt::format("sample '{}' cannot be written: {}", sample.key, why));
}

// WebDataset groups the members that follow each other and share the name up to the first dot, and takes the rest of
// the name, in lower case, for the member's key. Names are plain ASCII, so that every tar reader sees the same.
void checkNames(const Sample& sample) {
  const auto plain = [](char c) { return c > ' ' && c < 0x7f && c != '/' && c != '\\'; };
  if (sample.key.empty() ||
      !std::all_of(sample.key.begin(), sample.key.end(), [&](char c) { return plain(c) && c != '.'; })) {
    refuse(sample, "a key is printable ASCII without dots, slashes and spaces");
  }
  if (!isSplitName(sample.split)) refuse(sample, fmt::format("'{}' is no name of a split", sample.split));
  std::set<std::string_view> suffixes{kJsonSuffix};
  for (const Member& member : sample.members) {
    const std::string& suffix = member.suffix;
    if (suffix.empty() || suffix.front() == '.' ||
        !std::all_of(suffix.begin(), suffix.end(), [&](char c) { return plain(c) && !(c >= 'A' && c <= 'Z'); })) {
      refuse(sample, fmt::format("suffix '{}' is not lower-case printable ASCII without slashes and spaces", suffix));
    }
    if (!suffixes.insert(suffix).second) refuse(sample, fmt::format("suffix '{}' is there twice", suffix));
  }
}

struct OpenShard {
  ShardFile file;
  std::size_t record;   // index into the manifest's shards
  std::uint64_t bytes;  // that the file will have once closed

  OpenShard(const std::filesystem::path& path, std::size_t index)
      : file(path), record(index), bytes(ShardFile::kEndBytes) {}
};

}  // namespace

struct DatasetWriter::State {
  std::filesystem::path folder;
  std::uint64_t shardBytes = 0;
  std::map<std::string, std::unique_ptr<OpenShard>> open;  // by split
  std::map<std::string, std::uint64_t> shardsOfSplit;
  std::vector<ShardRecord> shards;
  std::vector<SampleRecord> samples;
  std::unordered_set<std::string> keys;
  std::uint64_t closedBytes = 0;
  bool finished = false;
  bool broken = false;  // a sample was written in part: no shard may be closed any more

  // The split's shard that has room for so many bytes.
  OpenShard& shardFor(const std::string& split, std::uint64_t bytes) {
    std::unique_ptr<OpenShard>& shard = open[split];
    if (shard && shard->bytes + bytes > shardBytes && shards[shard->record].samples > 0) close(shard);
    if (!shard) {
      const std::string name = shardName(split, shardsOfSplit[split]++);
      const std::filesystem::path file = folder / name;
      std::error_code failure;
      std::filesystem::create_directories(file.parent_path(), failure);
      if (failure)
        throw Error(fmt::format("{}: cannot be created: {}", file.parent_path().string(), failure.message()));
      shard = std::make_unique<OpenShard>(file, shards.size());
      shards.push_back({name, split, {}, 0, 0});
    }
    return *shard;
  }

  void close(std::unique_ptr<OpenShard>& shard) {
    const ShardFile::Whole whole = shard->file.close();
    ShardRecord& record = shards[shard->record];
    record.sha256 = whole.sha256;
    record.bytes = whole.bytes;
    closedBytes += whole.bytes;
    shard.reset();
  }
};

DatasetWriter::DatasetWriter(std::filesystem::path folder, bool overwrite, std::uint64_t shardBytes)
    : state_(std::make_unique<State>()) {
  prepareOutputFolder(folder, overwrite);
  state_->folder = std::move(folder);
  state_->shardBytes = shardBytes;
}

DatasetWriter::~DatasetWriter() {
  if (state_->finished) return;
  state_->open.clear();  // which removes their files
  for (const auto& [split, count] : state_->shardsOfSplit) {
    std::error_code notEmpty;
    std::filesystem::remove(state_->folder / split, notEmpty);
  }
}

void DatasetWriter::add(const Sample& sample) {
  State& s = *state_;
  if (s.finished) refuse(sample, "the dataset is finished");
  if (s.broken) refuse(sample, "an earlier one failed");
  checkNames(sample);
  if (!s.keys.insert(sample.key).second) refuse(sample, "its key was written before");

  SampleRecord record{sample.key, sample.split, 0, sample.scans, {}};
  const std::string json = sampleJson(record);
  std::vector<std::string_view> contents{json};
  record.members.push_back(fmt::format("{}.{}", sample.key, kJsonSuffix));
  for (const Member& member : sample.members) {
    record.members.push_back(fmt::format("{}.{}", sample.key, member.suffix));
    contents.push_back(member.bytes);
  }

  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < contents.size(); ++i) {
    bytes += ShardFile::memberBytes(record.members[i].size(), contents[i].size());
  }
  s.broken = true;
  OpenShard& shard = s.shardFor(sample.split, bytes);
  for (std::size_t i = 0; i < contents.size(); ++i) shard.file.add(record.members[i], contents[i]);
  shard.bytes += bytes;
  record.shard = static_cast<std::uint32_t>(shard.record);
  ++s.shards[shard.record].samples;
  s.samples.push_back(std::move(record));
  s.broken = false;
}

std::uint64_t DatasetWriter::bytesWritten() const {
  std::uint64_t bytes = state_->closedBytes;
  for (const auto& [split, shard] : state_->open) {
    if (shard) bytes += shard->bytes;
  }
  return bytes;
}

void DatasetWriter::finish(Manifest& manifest) {
  State& s = *state_;
  if (s.finished) throw Error("the dataset is finished already");
  if (s.broken) throw Error("the dataset cannot be finished: a sample could not be written");
  for (auto& [split, shard] : s.open) {
    if (shard) s.close(shard);
  }
  s.finished = true;
  manifest.shards = std::move(s.shards);
  manifest.samples = std::move(s.samples);
  writeFile(s.folder / kManifestName, toJson(manifest));
}

}  // namespace scanmill
