#include "pipeline/run/regenerate.h"

#include <fmt/core.h>

#include <algorithm>
#include <string_view>

#include "base/error.h"
#include "base/file.h"
#include "base/folder_lock.h"
#include "base/hash.h"
#include "base/own_folder.h"
#include "base/parallel.h"
#include "config/fields.h"
#include "config/version.h"
#include "dataset/manifest.h"
#include "dataset/shard_name.h"
#include "pipeline/plan/shard_jobs.h"
#include "pipeline/run/generate.h"
#include "pipeline/run/sample_maker.h"
#include "pipeline/scenes/shot_source.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

constexpr const char* kScratch = "again";  // name of the scratch folder within the dataset's hidden folder

[[noreturn]] void failDifferent(const std::string& what, const Manifest& manifest) {
  throw Error(
      fmt::format("{}: made again, its bytes differ from the manifest, since the scenes, files that they name or the "
                  "program (then {}, now {}) have changed; nothing was replaced",
                  what, manifest.programVersion, kVersion));
}

// Locks a dataset and creates a scratch folder within the dataset's hidden folder. The destructor removes the scratch
// folder with all its files.
class Scratch {
 public:
  explicit Scratch(const fs::path& dataset)
      : hidden_(dataset / kHiddenName),
        made_(makeFolders(dataset, hidden_)),
        lock_(std::make_unique<FolderLock>(dataset, hidden_ / "lock")) {}
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(folder(), ignored);
    lock_.reset();
    if (made_) fs::remove(hidden_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  fs::path folder() const { return hidden_ / kScratch; }

 private:
  fs::path hidden_;
  bool made_;
  std::unique_ptr<FolderLock> lock_;
};

// Returns the SHA-256 of a file; an empty text if the file cannot be read.
std::string hashOf(const fs::path& file) {
  try {
    return sha256OfFile(file);
  } catch (const Error&) {
    return {};
  }
}

SampleAddress addressOf(const Plan& plan, const std::string& key) {
  const std::vector<Sequence>& sequences = plan.pipeline.sequences;
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    if (!key.starts_with(sequences[s].key())) continue;
    for (std::uint32_t frame = 0; frame < sequences[s].frames; ++frame) {
      if (sequences[s].key(frame) == key) return {s, frame, 0};
    }
  }
  throw Error(fmt::format("the plan has no sample {}", key));
}

}  // namespace

std::vector<std::uint64_t> damagedShards(const fs::path& folder, const Manifest& manifest) {
  std::vector<char> damaged(manifest.shards.size());
  parallelFor(damaged.size(), 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      const fs::path file = folder / manifest.shards[i].file;
      std::error_code failure;
      damaged[i] = !fs::is_regular_file(file, failure) || fs::file_size(file, failure) != manifest.shards[i].bytes ||
                   hashOf(file) != manifest.shards[i].sha256;
    }
  });
  std::vector<std::uint64_t> numbers;
  for (std::size_t i = 0; i < damaged.size(); ++i) {
    if (damaged[i] != 0) numbers.push_back(i);
  }
  return numbers;
}

void regenerateShards(const fs::path& folder, const Manifest& manifest, const Plan& plan,
                      const std::vector<std::uint64_t>& shards, bool quiet, const std::atomic<bool>* stop) {
  const Scratch scratch(folder);
  fs::remove_all(scratch.folder());  // a process that was killed may have left files behind
  try {
    generate(plan,
             {.folder = scratch.folder(), .shards = {ShardChoice::Kind::Listed, shards}, .quiet = quiet, .stop = stop});
  } catch (const Error&) {
    if (stop != nullptr && *stop) throw Error("stopped: nothing was replaced");
    throw;
  }
  const auto made = [&](std::uint64_t shard) { return scratch.folder() / kHiddenName / manifest.shards[shard].file; };
  for (const std::uint64_t shard : shards) {
    const ShardRecord& stated = manifest.shards[shard];
    // The file is read back from the disk to compute its hash, so that only sound files are moved into the dataset.
    if (sha256OfFile(made(shard)) != stated.sha256) failDifferent(stated.file, manifest);
  }
  for (const std::uint64_t shard : shards) {
    const fs::path place = folder / manifest.shards[shard].file;
    moveFile(folder, made(shard), place);
    syncFolder(place.parent_path());
  }
}

std::vector<std::string> regenerateSample(const Manifest& manifest, const Plan& plan, const std::string& key,
                                          const fs::path& into) {
  const auto record = std::find_if(manifest.samples.begin(), manifest.samples.end(),
                                   [&](const SampleRecord& sample) { return sample.key == key; });
  if (record == manifest.samples.end()) {
    std::vector<std::string> keys;
    for (const SampleRecord& sample : manifest.samples) keys.push_back(sample.key);
    throw InputError(fmt::format("the dataset has no sample '{}'{}", key, suggestion(key, keys)));
  }
  ShotSource source(plan);
  SampleMaker maker(source, {}, {}, false, [](const Sequence&) {});
  const Sample sample = maker.make(addressOf(plan, key)).sample;
  std::vector<std::string> names{key + ".json"};
  std::vector<std::string> contents{sampleJson({sample.key, sample.split, 0, sample.scans, {}})};
  for (const Member& member : sample.members) {
    names.push_back(key + "." + member.suffix);
    contents.push_back(member.bytes);
  }
  if (names != record->members) failDifferent(key, manifest);
  for (std::size_t i = 0; i < names.size() && !record->xxh3.empty(); ++i) {
    if (xxh3(contents[i]) != record->xxh3[i]) failDifferent(names[i], manifest);
  }
  std::error_code failure;
  fs::create_directories(into, failure);
  if (failure) throw InputError({into.string()}, "cannot be made: " + failure.message());
  for (std::size_t i = 0; i < names.size(); ++i) writeFile(into / names[i], contents[i]);
  return names;
}

}  // namespace scanmill
