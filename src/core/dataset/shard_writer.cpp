#include "dataset/shard_writer.h"

#include <fmt/core.h>

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/hash.h"
#include "base/own_folder.h"
#include "dataset/manifest.h"
#include "dataset/shard_name.h"

namespace scanmill {

namespace {

constexpr std::string_view kJsonSuffix = "json";

[[noreturn]] void refuse(const Sample& sample, const std::string& why) {
  throw Error(fmt::format("sample '{}' cannot be written: {}", sample.key, why));
}

// Throws Error for names that WebDataset would misread. WebDataset joins consecutive members to a sample if their names
// agree up to the first dot, and uses the rest of the name, in lower case, as the member's key. Names must be printable
// ASCII, so that all tar readers read the same names.
void checkNames(const Sample& sample) {
  const auto plain = [](char c) { return c > ' ' && c < 0x7f && c != '/' && c != '\\'; };
  if (sample.key.empty() ||
      !std::all_of(sample.key.begin(), sample.key.end(), [&](char c) { return plain(c) && c != '.'; })) {
    refuse(sample, "its key must be printable ASCII without dots, slashes and spaces");
  }
  if (!isSplitName(sample.split)) refuse(sample, fmt::format("'{}' is not a name of a split", sample.split));
  std::set<std::string_view> suffixes{kJsonSuffix};
  for (const Member& member : sample.members) {
    const std::string& suffix = member.suffix;
    if (suffix.empty() || suffix.front() == '.' ||
        !std::all_of(suffix.begin(), suffix.end(), [&](char c) { return plain(c) && !(c >= 'A' && c <= 'Z'); })) {
      refuse(sample,
             fmt::format("the suffix '{}' must be lower-case printable ASCII without slashes and spaces", suffix));
    }
    if (!suffixes.insert(suffix).second) refuse(sample, fmt::format("the suffix '{}' is used twice", suffix));
  }
}

SampleRecord recordOf(const Sample& sample) {
  return {sample.key, sample.split, 0, sample.scans, {}, {}, sample.objects, sample.draws, sample.time};
}

std::filesystem::path madeFolderOf(const std::filesystem::path& folder, const std::filesystem::path& file) {
  std::filesystem::create_directories(folder);
  makeFolders(folder, file.parent_path());
  return file;
}

}  // namespace

std::uint64_t bytesInShard(const Sample& sample) {
  const auto bytesOf = [&](std::string_view suffix, std::size_t size) {
    return ShardFile::memberBytes(sample.key.size() + 1 + suffix.size(), size);
  };
  std::uint64_t bytes = bytesOf(kJsonSuffix, sampleJson(recordOf(sample)).size());
  for (const Member& member : sample.members) bytes += bytesOf(member.suffix, member.bytes.size());
  return bytes;
}

ShardWriter::ShardWriter(const std::filesystem::path& folder, const std::string& name, const std::string& split)
    : part_{{name, split, {}, 0, 0}, {}}, file_(folder, madeFolderOf(folder, folder / name)) {}

void ShardWriter::add(const Sample& sample) {
  if (broken_) refuse(sample, "an earlier sample of this shard failed");
  checkNames(sample);
  if (sample.split != part_.shard.split) {
    refuse(sample, fmt::format("it belongs to the split {}, but the shard to {}", sample.split, part_.shard.split));
  }
  SampleRecord record = recordOf(sample);
  const std::string json = sampleJson(record);
  std::vector<std::string_view> contents{json};
  record.members.push_back(fmt::format("{}.{}", sample.key, kJsonSuffix));
  for (const Member& member : sample.members) {
    record.members.push_back(fmt::format("{}.{}", sample.key, member.suffix));
    contents.push_back(member.bytes);
  }
  broken_ = true;
  for (std::size_t i = 0; i < contents.size(); ++i) {
    file_.add(record.members[i], contents[i]);
    record.xxh3.push_back(xxh3(contents[i]));
    bytes_ += ShardFile::memberBytes(record.members[i].size(), contents[i].size());
  }
  part_.samples.push_back(std::move(record));
  broken_ = false;
}

ShardPart ShardWriter::finish() {
  if (broken_) throw Error(fmt::format("{}: cannot be finished: a sample could not be written", part_.shard.file));
  const ShardFile::Whole whole = file_.close();
  part_.shard.sha256 = whole.sha256;
  part_.shard.bytes = whole.bytes;
  part_.shard.samples = part_.samples.size();
  return std::move(part_);
}

}  // namespace scanmill
