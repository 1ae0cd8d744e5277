// Recreates parts of a dataset from its manifest, byte for byte.

#include <map>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/folder_lock.h"
#include "base/hash.h"
#include "base/own_folder.h"
#include "config/version.h"
#include "dataset/folder_contents.h"
#include "dataset/names.h"
#include "dataset/parts.h"
#include "pipeline/run/generate.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

constexpr const char* kScratch = "again";  // name of the scratch folder within the dataset's hidden folder

[[noreturn]] void failDifferent(const std::string& what, const Manifest& manifest) {
  throw Error(
      "{}: made again, its bytes differ from the manifest, since the scenes, files that they name or the "
      "program (then {}, now {}) have changed; nothing was replaced",
      what, manifest.programVersion, kVersion);
}

// Locks a dataset for a regeneration whose files are made in folder(), within the dataset's hidden folder. The
// destructor removes folder() with all its files and releases the lock.
class RegenerationFolder {
 public:
  explicit RegenerationFolder(const fs::path& dataset)
      : hidden_(dataset / kHiddenName),
        hiddenIsNew_(makeFolders(dataset, hidden_)),
        lock_(std::make_unique<FolderLock>(dataset, hidden_ / "lock")) {}
  ~RegenerationFolder() {
    std::error_code ignored;
    fs::remove_all(folder(), ignored);
    lock_.reset();
    if (hiddenIsNew_) fs::remove(hidden_, ignored);
  }
  RegenerationFolder& operator=(RegenerationFolder&&) = delete;  // neither copied nor moved

  fs::path folder() const { return hidden_ / kScratch; }

 private:
  fs::path hidden_;
  bool hiddenIsNew_;
  std::unique_ptr<FolderLock> lock_;
};

}  // namespace

void regenerateShards(const fs::path& folder, Manifest manifest, const Plan& plan,
                      const std::vector<std::uint64_t>& shards, bool quiet, const std::atomic<bool>* stop) {
  const RegenerationFolder scratch(folder);
  fs::remove_all(scratch.folder());  // a process that was killed may have left files behind
  try {
    generate(plan,
             {.folder = scratch.folder(), .shards = {ShardChoice::Kind::Listed, shards}, .quiet = quiet, .stop = stop});
  } catch (const Error&) {
    if (stop != nullptr && *stop) throw Error("stopped: nothing was replaced");
    throw;
  }
  const auto madeFile = [&](std::uint64_t shard) {
    return scratch.folder() / kHiddenName / manifest.shards[shard].file;
  };
  std::map<std::string, std::string> descriptions;  // texts of the files beside the shards, by name
  for (const std::uint64_t shard : shards) {
    const ShardRecord& record = manifest.shards[shard];
    // The file is read back from the disk to compute its hash, so that only sound files are moved into the dataset.
    if (sha256OfFile(madeFile(shard)) != record.sha256) failDifferent(record.file, manifest);
    if (record.samplesSha256.empty()) continue;
    const std::string partFile = madeFile(shard).string() + kRecordSuffix;
    DatasetPart part = parsePart(readFile(partFile), partFile);
    for (std::size_t i = 0; i < part.numbers.size(); ++i) {
      part.manifest.samples[i].shard = static_cast<std::uint32_t>(shard);
      manifest.samples.at(part.numbers[i]) = std::move(part.manifest.samples[i]);
    }
    const std::string file = samplesFileOf(record.file);
    descriptions[file] = samplesJson(manifest, static_cast<std::uint32_t>(shard), part.numbers);
    if (sha256(descriptions[file]) != record.samplesSha256) failDifferent(file, manifest);
  }
  for (const std::uint64_t shard : shards) {
    const fs::path target = folder / manifest.shards[shard].file;
    moveFile(folder, madeFile(shard), target);
    syncFolder(target.parent_path());
  }
  for (const auto& [file, text] : descriptions) writeFile(folder, folder / file, text);
}

}  // namespace scanmill
