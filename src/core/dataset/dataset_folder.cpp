#include "dataset/dataset_folder.h"

#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <exception>
#include <set>
#include <thread>

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/own_folder.h"
#include "dataset/card.h"
#include "dataset/folder_contents.h"
#include "dataset/names.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

constexpr const char* kLockName = "lock";
constexpr const char* kClaimSuffix = ".lock";     // appended to a shard's name to get the name of its lock file
constexpr const char* kStartName = "begin.lock";  // lock of the process that starts a dataset in a shared folder
// Longest time to wait for another process that starts or completes a dataset (kProcessWait), and for a folder to
// become usable (kFolderWait). kPause: time between two attempts.
constexpr std::chrono::seconds kProcessWait(60);
constexpr std::chrono::seconds kFolderWait(2);
constexpr std::chrono::milliseconds kPause(50);

// Returns true if the path exists. Throws Error if this cannot be determined.
bool surelyExists(const fs::path& path) {
  std::error_code failure;
  const fs::file_status status = fs::status(path, failure);
  if (fs::status_known(status)) return fs::exists(status);
  throw Error("{}: {}", path.string(), failure.message());
}

// Returns the nearest folder above `folder` that has a complete or unfinished dataset; an empty path if there is none.
fs::path datasetAbove(const fs::path& folder) {
  fs::path ancestor = fs::absolute(folder).lexically_normal();
  if (!ancestor.has_filename()) ancestor = ancestor.parent_path();  // the path ends in a slash
  while (ancestor.has_relative_path()) {
    ancestor = ancestor.parent_path();
    try {
      if (isUnfinished(ancestor) || !filesListedIn(ancestor / kManifestName).empty()) return ancestor;
    } catch (const InputError&) {
      continue;  // a manifest of another program
    }
  }
  return {};
}

// Throws InputError if the path cannot be an output folder. Also throws it for a link to a folder in the path, and for
// a link or file with the name of the hidden folder: files would be written or removed at another place.
void checkPath(const fs::path& folder) {
  if (const fs::path dataset = datasetAbove(folder); !dataset.empty()) {
    throw InputError({folder.string()},
                     "is in the dataset {}, to which no other files belong: choose another output folder with -o",
                     dataset.string());
  }
  if (fs::exists(folder) && !fs::is_directory(folder)) {
    throw InputError({folder.string()}, "is a file: choose another output folder");
  }
  if (!fs::exists(folder)) return;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const bool isLinkToFolder = entry.is_symlink() && entry.is_directory();
    const bool isHiddenNoFolder = entry.path().filename() == kHiddenName && !entry.is_directory();
    if (isLinkToFolder || isHiddenNoFolder) {
      throw ForeignFile({entry.path().string()}, "is a link or a file, where this program has a folder: remove it");
    }
  }
}

// Throws InputError if `use` does not allow what the folder contains.
void checkContents(const fs::path& folder, FolderUse use) {
  if (!fs::exists(folder)) return;
  const FolderContents contents = contentsOf(folder);
  if (use == FolderUse::Replace) return checkOwnership(folder, contents);
  if ((use == FolderUse::Resume || use == FolderUse::Share) && contents.unfinished) return;
  if (use == FolderUse::Share && contents.manifest) return;
  if (contents.unfinished) {
    throw InputError({folder.string()},
                     "has an unfinished dataset: add --resume to continue it, or --overwrite to start again (in Python "
                     "resume=True, overwrite=True)");
  }
  if (use == FolderUse::Resume && contents.manifest) {
    throw InputError(
        {folder.string()},
        "has a complete dataset of another pipeline (another `--set` makes another pipeline), of changed files that "
        "the pipeline names, or of another version of this program: choose another output folder, or add --overwrite");
  }
  if (contents.empty()) return;
  const char* const remedy =
      contents.manifest         ? "add --overwrite to replace the dataset in it, or choose another output "
                                  "folder with -o"
      : contents.shards.empty() ? "choose another output folder with -o"
                                : "its shards have no manifest, so choose another output folder with -o";
  throw InputError({folder.string()}, "exists and is not empty: {}", remedy);
}

// Removes all files in the hidden folder except the lock; this program wrote all of them. The plan is removed first,
// because without a plan the other files do not count as an unfinished dataset.
void clearHidden(const fs::path& hidden) {
  removeFile(hidden, hidden / kPlanName);
  std::vector<fs::path> paths;
  for (const fs::directory_entry& entry : fs::directory_iterator(hidden)) {
    if (entry.path().filename() != kLockName) paths.push_back(entry.path());
  }
  for (const fs::path& path : paths) fs::remove_all(path);
}

// Removes a shard, and also the folder of its split if that is then empty. `name`: relative to the dataset's folder.
void removeShard(const fs::path& folder, const std::string& name) {
  removeFile(folder, folder / name);
  std::error_code notEmpty;
  if ((folder / name).parent_path() != folder) fs::remove((folder / name).parent_path(), notEmpty);
}

// Returns the text of the manifest. If the descriptions of all samples together take more than `mostBytes`, they are
// left out of the manifest and written to files beside the shards.
std::string manifestText(const fs::path& folder, std::uint64_t mostBytes, const Manifest& manifest) {
  std::vector<std::vector<std::uint64_t>> samplesOfShard(manifest.shards.size());  // indices into manifest.samples
  for (std::size_t i = 0; i < manifest.samples.size(); ++i) samplesOfShard[manifest.samples[i].shard].push_back(i);
  std::uint64_t bytes = 0;
  for (std::uint32_t shard = 0; shard < samplesOfShard.size() && bytes <= mostBytes; ++shard) {
    bytes += samplesJson(manifest, shard, samplesOfShard[shard]).size();
  }
  if (bytes <= mostBytes) return toJson(manifest);
  Manifest head = manifest;
  head.samples.clear();
  for (std::uint32_t shard = 0; shard < samplesOfShard.size(); ++shard) {
    const std::string text = samplesJson(manifest, shard, samplesOfShard[shard]);
    writeFile(folder, folder / samplesFileOf(manifest.shards[shard].file), text);
    head.shards[shard].samplesSha256 = sha256(text);
  }
  return toJson(head);
}

}  // namespace

void DatasetFolder::check(const fs::path& folder, FolderUse use) {
  try {
    if (use != FolderUse::Share && isUnfinished(folder)) {
      // Throws an InputError that names the process that is writing into the folder, if there is one.
      const FolderLock free(folder, folder / kHiddenName / kLockName);
    }
    checkPath(folder);
    checkContents(folder, use);
  } catch (const fs::filesystem_error& error) {
    throw InputError({folder.string()}, "cannot be used as output folder: " + error.code().message());
  }
}

void DatasetFolder::tidy(const fs::path& folder) {
  const fs::path hidden = folder / kHiddenName;
  std::error_code ignored;
  if (isUnfinished(folder) || !fs::is_directory(fs::symlink_status(hidden, ignored))) return;
  std::string holder;
  if (const auto lock = FolderLock::tryTake(folder, hidden / kLockName, LockKind::Alone, holder)) clearHidden(hidden);
  fs::remove(hidden, ignored);
}

DatasetPlan DatasetFolder::planned(const fs::path& folder) {
  const fs::path file = folder / kHiddenName / kPlanName;
  if (!isUnfinished(folder)) {
    throw InputError({folder.string()}, "has no unfinished dataset: give the folder that `generate -o` was given");
  }
  return parsePlan(readFile(file), file.string());
}

DatasetFolder::DatasetFolder(fs::path folder, FolderUse use, DatasetPlan plan)
    : folder_(std::move(folder)), staging_(folder_ / kHiddenName), plan_(std::move(plan)) {
  check(folder_, use);
  try {
    created_ = !fs::exists(folder_);
    if (use == FolderUse::Share) {
      share();
    } else {
      fs::create_directories(folder_);
      makeFolders(folder_, staging_);
      lock_ = std::make_unique<FolderLock>(folder_, staging_ / kLockName);
    }
    checkPath(folder_);  // check again: another process may have changed the folder before it was locked
    checkContents(folder_, use);
    complete_ = shared_ && !isUnfinished(folder_) && fs::exists(folder_ / kManifestName);
    identity_ = identityOf(folder_);
    if (!complete_) writeOrMatchPlan(use);
  } catch (const fs::filesystem_error& error) {
    leave();
    throw InputError({folder_.string()}, "cannot be used as output folder: " + error.code().message());
  } catch (const Error&) {
    leave();
    throw;
  }
}

DatasetFolder::Identity DatasetFolder::identityOf(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return {.error = errno};
  return {.device = status.st_dev, .inode = status.st_ino};
}

// Releases the lock. Removes the hidden folder if it is empty, and also the dataset's folder if the constructor has
// created this folder and nothing is in it, as when no shard was completed.
void DatasetFolder::leave() {
  std::error_code ignored;
  lock_.reset();
  fs::remove(staging_, ignored);
  if (created_) fs::remove(folder_, ignored);
}

// Takes a shared lock. Another process that is completing the dataset may have the lock or remove the hidden folder.
// share() therefore tries again: up to kProcessWait for the lock, up to kFolderWait after other errors.
void DatasetFolder::share() {
  shared_ = true;
  const auto begin = std::chrono::steady_clock::now();
  const auto waitedLongerThan = [&](std::chrono::seconds limit) {
    return std::chrono::steady_clock::now() - begin > limit;
  };
  while (lock_ == nullptr) {
    try {
      fs::create_directories(folder_);
      makeFolders(folder_, staging_);
      lock_ = std::make_unique<FolderLock>(folder_, staging_ / kLockName, LockKind::Shared);
    } catch (const ForeignFile&) {
      throw;
    } catch (const InputError&) {  // another process has the lock
      if (waitedLongerThan(kProcessWait)) throw;
    } catch (const Error&) {  // the hidden folder was removed, or the disk fails
      if (waitedLongerThan(kFolderWait)) throw;
    }
    if (lock_ == nullptr) std::this_thread::sleep_for(kPause);
  }
}

// Waits for the lock under which a process starts a shared dataset. Throws InputError if this takes over kProcessWait.
std::unique_ptr<FolderLock> DatasetFolder::lockStart() const {
  const auto deadline = std::chrono::steady_clock::now() + kProcessWait;
  std::string holder;  // the process that has the lock
  while (true) {
    auto lock = FolderLock::tryTake(folder_, staging_ / kStartName, LockKind::Alone, holder);
    if (lock != nullptr) return lock;
    if (std::chrono::steady_clock::now() > deadline) {
      throw InputError({folder_.string()},
                       "is in use by " + holder + ", which starts a dataset: wait until it has started");
    }
    std::this_thread::sleep_for(kPause);
  }
}

// Writes the plan. If an unfinished dataset is continued, checks instead that it has the same plan. Deletes only this
// program's files, because checkContents() has refused folders with other files.
void DatasetFolder::writeOrMatchPlan(FolderUse use) {
  // Takes no lock on a file system without locks: there the lock file of a process that was killed on another host
  // would block the folder.
  const std::unique_ptr<FolderLock> lock = shared_ && lock_->keepsOthersOut() ? lockStart() : nullptr;
  const fs::path planFile = staging_ / kPlanName;
  const bool continues = shared_ || use == FolderUse::Resume;
  if (continues && fs::exists(planFile)) {
    if (readFile(planFile) == toJson(plan_)) return;
    throw InputError(
        {folder_.string()},
        "has an unfinished dataset of another pipeline (another `--set` makes another pipeline), of changed files that "
        "the pipeline names, or of another version of this program: choose another folder, or add --overwrite");
  }
  // Shards without a manifest are left over from a run that was killed in publish(). Shards with a manifest are a
  // complete dataset, which stays until the new dataset is complete.
  if (!fs::exists(folder_ / kManifestName)) {
    for (const std::string& name : writtenFiles(folder_)) removeShard(folder_, name);
  }
  if (!shared_) clearHidden(staging_);
  writeFile(folder_, planFile, toJson(plan_));
}

bool DatasetFolder::makeAlone() {
  if (!shared_ || (lock_ != nullptr && lock_->makeAlone())) return true;
  lock_.reset();
  return false;
}

DatasetFolder::~DatasetFolder() {
  if (identityOf(folder_) != identity_ || !makeAlone()) return;
  try {
    if (published_ || complete_ || !hasRecords()) clearHidden(staging_);
  } catch (const std::exception&) {
    created_ = false;  // the folder may have changed: it stays
  }
  leave();
}

// Returns the path of a shard: in staging_, or its final path if an earlier process moved the shard there before it was
// killed in publish().
fs::path DatasetFolder::shardPath(const std::string& name) const {
  return surelyExists(staging_ / name) ? staging_ / name : folder_ / name;
}

std::unique_ptr<FolderLock> DatasetFolder::claim(const std::string& name) {
  const fs::path file = staging_ / (name + kClaimSuffix);
  makeFolders(folder_, file.parent_path());
  std::string holder;
  // On a file system without locks several processes may write the same shard, which is harmless: they write the same
  // bytes.
  return FolderLock::tryTake(folder_, file, lock_->keepsOthersOut() ? LockKind::Alone : LockKind::Shared, holder);
}

void DatasetFolder::storeRecord(const DatasetPart& part) {
  requireSameFolder();
  writeFile(folder_, staging_ / (part.manifest.shards.at(0).file + kRecordSuffix), toJson(part));
}

bool DatasetFolder::hasRecords() const {
  return !shardsRecordedIn(staging_).empty();
}

std::optional<DatasetPart> DatasetFolder::findRecord(const std::string& name, Check check) const {
  const fs::path record = staging_ / (name + kRecordSuffix);
  const fs::path shard = shardPath(name);
  if (!surelyExists(record) || !surelyExists(shard)) return std::nullopt;
  DatasetPart part;
  const std::string text = readFile(record);
  try {
    part = parsePart(text, record.string());
  } catch (const InputError&) {
    return std::nullopt;  // a damaged record is treated as missing
  }
  if (part.plan != plan_.hash) {
    throw InputError({record.string()},
                     "belongs to another pipeline, changed files that it names, or another version of this program "
                     "than the other shards: remove this file and its shard");
  }
  const ShardRecord& recorded = part.manifest.shards[0];
  std::error_code failure;
  const std::uint64_t bytes = fs::file_size(shard, failure);
  if (failure) throw Error("{}: {}", shard.string(), failure.message());
  if (recorded.file != name || bytes != recorded.bytes) return std::nullopt;
  if (check == Check::Bytes && sha256OfFile(shard) != recorded.sha256) return std::nullopt;
  return part;
}

void DatasetFolder::requireSameFolder() const {
  const Identity current = identityOf(folder_);
  if (current == identity_) return;
  const bool failed = current.error != 0 && current.error != ENOENT;
  const std::string why = failed ? fmt::format(" ({})", std::strerror(current.error)) : "";
  throw Error("{}: was removed or replaced while the dataset was written{}", folder_.string(), why);
}

// Removes the dataset that is replaced: its manifest, its shards except those that belong to the new dataset, and
// temporary files.
void DatasetFolder::removeReplaced() const {
  if (fs::exists(folder_ / kManifestName)) {
    // The manifest is moved first, and the move is flushed to the disk, so that a mixture of old and new files never
    // looks complete.
    moveFile(folder_, folder_ / kManifestName, staging_ / kReplacedName);
    syncFolder(folder_);
  }
  for (const std::string& name : filesListedIn(staging_ / kReplacedName)) {
    // A process that was killed in publish() may have moved a shard of the new dataset here.
    const bool isNew = fs::exists(staging_ / (name + kRecordSuffix)) && !fs::exists(staging_ / name);
    requireSameFolder();
    if (!isNew) removeShard(folder_, name);
  }
  for (const std::string& name : contentsOf(folder_).leftovers) removeFile(folder_, folder_ / name);
}

// Writes a file under a temporary name, calls check() and, unless check() throws, gives the file its final name.
void DatasetFolder::writeChecked(std::string_view name, const std::string& bytes,
                                 const std::function<void()>& check) const {
  requireSameFolder();
  AtomicFile file(folder_, folder_ / name);
  file.write(bytes);
  file.flush();
  requireSameFolder();
  check();
  file.commit();
}

void DatasetFolder::publish(const Manifest& manifest, std::uint64_t mostSampleBytes) {
  try {
    requireSameFolder();
    for (const ShardRecord& shard : manifest.shards) {
      const fs::path file = shardPath(shard.file);
      if (fs::file_size(file) == shard.bytes) continue;
      throw Error("{}: has changed since it was written: --resume makes it again", file.string());
    }
    removeReplaced();
    std::set<fs::path> shardFolders;
    for (const ShardRecord& shard : manifest.shards) {
      requireSameFolder();
      if (fs::exists(staging_ / shard.file)) moveFile(folder_, staging_ / shard.file, folder_ / shard.file);
      shardFolders.insert((folder_ / shard.file).parent_path());
    }
    writeChecked(kCardName, cardText(manifest), [] {});
    const std::string text = manifestText(folder_, mostSampleBytes, manifest);
    syncFolder(folder_);
    for (const fs::path& folder : shardFolders) syncFolder(folder);
    // The manifest is the last file. Once it has its name, the dataset counts as complete.
    writeChecked(kManifestName, text, [&] {
      for (const ShardRecord& shard : manifest.shards) {
        const fs::path file = folder_ / shard.file;
        if (!surelyExists(file)) {
          throw Error("{}: no longer exists: --resume makes it again", file.string());
        }
      }
    });
    published_ = true;
  } catch (const fs::filesystem_error& error) {
    throw Error("{}: {}", folder_.string(), error.what());
  }
}

}  // namespace scanmill
