// Reads the manifest of a dataset, and the files beside the shards that describe the samples of large datasets.

#include <fmt/core.h>

#include <algorithm>
#include <set>
#include <string_view>

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "dataset/folder_contents.h"
#include "dataset/json_record.h"
#include "dataset/manifest.h"
#include "dataset/shard_name.h"

namespace scanmill {

namespace {

// Returns the text of a file that describes the samples of a shard. Throws InputError if its SHA-256 is not the stated
// one, or if it is larger than any description of a shard of this size, which has its samples' descriptions, too.
std::string soundText(const std::filesystem::path& file, const ShardRecord& shard) {
  constexpr std::uint64_t kLeast = 1 << 20;
  std::error_code error;
  const std::uint64_t bytes = std::filesystem::file_size(file, error);
  std::string text = error || bytes / 4 <= kLeast + shard.bytes ? readFile(file) : std::string();
  if (sha256(text) == shard.samplesSha256) return text;
  throw InputError({file.string()}, "was changed since it was written: its SHA-256 differs from the manifest");
}

// Parses the text that describes a shard's samples, and stores each sample in `samples` at the sample's number.
// `samples` has the size of the complete dataset.
void parseSamples(const std::string& text, const std::filesystem::path& folder, std::uint32_t number,
                  const Manifest& head, std::vector<SampleRecord>& samples) {
  const ShardRecord& shard = head.shards[number];
  const std::string file = (folder / samplesFileOf(shard.file)).string();
  const Json json = parseJson(text, file);
  const JsonNode root(json, "", file);
  root.keys({"shard", "numbers", "samples"});
  std::vector<std::uint64_t> numbers;
  root["numbers"].forEach([&](const JsonNode& item) {
    numbers.push_back(item.integer<std::uint64_t>());
    if (numbers.back() >= samples.size())
      item.fail(fmt::format("is not below {}, the number of samples", samples.size()));
  });
  std::size_t next = 0;
  root["samples"].forEach([&](const JsonNode& item) {
    SampleRecord sample;
    readJson(item, sample, {&head.ontology, &head});
    if (sample.shard != number) item["shard"].fail(fmt::format("is not {}, the number of {}", number, shard.file));
    if (next >= numbers.size() || !samples[numbers[next]].key.empty())
      item.fail("has no number, or the number of another sample");
    samples[numbers[next++]] = std::move(sample);
  });
  if (next != shard.samples) root["samples"].fail(fmt::format("has {} entries, not {}", next, shard.samples));
}

// Adds the samples that the files beside the shards describe to a manifest: see readManifest().
Manifest described(Manifest manifest, const std::filesystem::path& folder,
                   std::map<std::uint32_t, std::string>& undescribed) {
  const std::filesystem::path file = folder / kManifestName;
  const auto inFile = [](const ShardRecord& shard) { return !shard.samplesSha256.empty(); };
  if (std::ranges::none_of(manifest.shards, inFile)) return manifest;
  constexpr std::uint64_t kMost = 10'000'000;  // 2 GB
  std::uint64_t count = 0;
  for (const ShardRecord& shard : manifest.shards) {
    count += std::min(shard.samples, kMost + 1);
    if (count > kMost) throw InputError({file.string()}, fmt::format("states more than {} samples", kMost));
  }
  std::vector<SampleRecord> samples(count);
  for (std::uint32_t shard = 0; shard < manifest.shards.size(); ++shard) {
    const ShardRecord& record = manifest.shards[shard];
    std::string text;
    try {
      text = soundText(folder / samplesFileOf(record.file), record);
    } catch (const InputError& error) {
      undescribed[shard] = error.what();
      continue;
    }
    parseSamples(text, folder, shard, manifest, samples);
  }
  std::set<std::string_view> keys;
  for (const SampleRecord& sample : samples) {
    if (!sample.key.empty() && !keys.insert(sample.key).second) {
      throw InputError({file.string()}, "has two samples " + sample.key);
    }
  }
  manifest.samples = std::move(samples);
  return manifest;
}

}  // namespace

Manifest readManifest(const std::filesystem::path& folder) {
  std::map<std::uint32_t, std::string> undescribed;
  Manifest manifest = readManifest(folder, undescribed);
  if (undescribed.empty()) return manifest;
  const std::size_t others = undescribed.size() - 1;
  throw InputError(fmt::format(
      "{}{}\nnext: `scanmill regenerate {}` makes it again", undescribed.begin()->second,
      others == 0 ? "" : fmt::format(" (and so are {} more files that describe samples)", others), folder.string()));
}

Manifest readManifest(const std::filesystem::path& folder, std::map<std::uint32_t, std::string>& undescribed) {
  const std::filesystem::path file = folder / kManifestName;
  requireDataset(folder);
  const std::string text = readFile(file);
  try {
    return described(parseManifest(text, file.string()), folder, undescribed);
  } catch (const InputError& error) {
    try {
      requireStatedDigest(file, text);
    } catch (const InputError& changed) {  // files that contradict it may be sound
      throw InputError(fmt::format("{}; {}", changed.what(), error.what()));
    }
    throw;
  }
}

}  // namespace scanmill
