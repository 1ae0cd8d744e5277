#include "pipeline/run/regenerate.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/folder_lock.h"
#include "base/hash.h"
#include "base/own_folder.h"
#include "base/parallel.h"
#include "config/fields.h"
#include "config/version.h"
#include "dataset/manifest.h"
#include "dataset/sample_names.h"
#include "dataset/shard_name.h"
#include "dataset/shard_samples.h"
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

// Returns the sequence and the number of the frame in a sample's key.
std::pair<std::string, std::uint64_t> frameOf(const std::string& key) {
  const KeyParts parts = partsOfKey(key);
  std::uint64_t frame = 0;
  std::from_chars(parts.frame.data(), parts.frame.data() + parts.frame.size(), frame);
  return {parts.sequence, frame};
}

// Returns the probable numbers of a shard's samples. The frames of a sequence have consecutive numbers; `starts` has
// the numbers of the first frames, as far as they are known. Other samples get the lowest numbers that no known sample
// has.
std::vector<std::uint64_t> probableNumbers(const Manifest& manifest, const std::vector<SampleRecord>& samples,
                                           const std::map<std::string, std::uint64_t>& starts) {
  std::vector<std::uint64_t> numbers;
  std::uint64_t next = 0;
  for (const SampleRecord& sample : samples) {
    const auto [sequence, frame] = frameOf(sample.key);
    if (const auto start = starts.find(sequence); start != starts.end()) {
      next = start->second + frame;
    } else {
      while (next < manifest.samples.size() && !manifest.samples[next].key.empty()) ++next;
    }
    numbers.push_back(next++);
  }
  return numbers;
}

// Adds a shard's samples to the manifest and writes the file that describes them. Returns false, and changes nothing,
// if these numbers do not give the file whose hash the manifest states.
bool describe(const fs::path& folder, Manifest& manifest, std::uint64_t shard, const std::vector<SampleRecord>& samples,
              const std::vector<std::uint64_t>& numbers) {
  const auto isFree = [&](std::uint64_t number) {
    return number < manifest.samples.size() && manifest.samples[number].key.empty();
  };
  if (numbers.size() != samples.size() || !std::all_of(numbers.begin(), numbers.end(), isFree)) return false;
  for (std::size_t i = 0; i < numbers.size(); ++i) manifest.samples[numbers[i]] = samples[i];
  const ShardRecord& record = manifest.shards[shard];
  const std::string text = samplesJson(manifest, static_cast<std::uint32_t>(shard), numbers);
  if (sha256(text) == record.samplesSha256) {
    writeFile(folder, folder / samplesFileOf(record.file), text);
    return true;
  }
  for (const std::uint64_t number : numbers) manifest.samples[number] = {};
  return false;
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

void describeShards(const fs::path& folder, Manifest& manifest, const std::vector<std::uint64_t>& shards,
                    const std::function<Plan()>& plan) {
  const Scratch lock(folder);
  std::map<std::string, std::uint64_t> starts;  // number of the first frame, by sequence
  const auto learn = [&](const std::string& key, std::uint64_t number) {
    const auto [sequence, frame] = frameOf(key);
    starts.emplace(sequence, number - frame);
  };
  for (std::uint64_t i = 0; i < manifest.samples.size(); ++i) {
    if (!manifest.samples[i].key.empty()) learn(manifest.samples[i].key, i);
  }
  const auto isDescribed = [&](std::uint64_t shard) {
    const std::vector<SampleRecord> samples = samplesOfShard(folder, manifest, static_cast<std::uint32_t>(shard));
    const std::vector<std::uint64_t> numbers = probableNumbers(manifest, samples, starts);
    if (!describe(folder, manifest, shard, samples, numbers)) return false;
    for (std::size_t i = 0; i < numbers.size(); ++i) learn(samples[i].key, numbers[i]);
    return true;
  };
  std::vector<std::uint64_t> left = shards;
  while (std::erase_if(left, isDescribed) > 0) continue;  // each round knows the numbers of more samples
  if (left.empty()) return;
  const std::vector<ShardJob> jobs = shardJobs(plan());
  std::string different;
  for (const std::uint64_t shard : left) {
    std::vector<std::uint64_t> numbers;
    for (const SampleAddress& sample : jobs[shard].samples) numbers.push_back(sample.number);
    const auto samples = samplesOfShard(folder, manifest, static_cast<std::uint32_t>(shard));
    if (describe(folder, manifest, shard, samples, numbers)) continue;
    different += (different.empty() ? "" : ", ") + samplesFileOf(manifest.shards[shard].file);
  }
  if (different.empty()) return;
  throw Error(
      fmt::format("{}: made again from the shards, the bytes differ from the SHA-256 in the manifest, since the "
                  "program (then {}, now {}) has changed or the manifest is damaged; they were not replaced",
                  different, manifest.programVersion, kVersion));
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
  std::vector<std::string> contents{
      sampleJson({sample.key, sample.split, 0, sample.scans, {}, {}, {}, sample.draws, sample.time})};
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
