#include "dataset/folder_contents.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstring>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "dataset/manifest.h"
#include "dataset/names.h"
#include "dataset/recording.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

// Returns the sorted names, relative to the folder, of the files in the folder and in its direct subfolders. Leaves out
// the hidden folder (kHiddenName) and subfolders that cannot be read.
std::vector<std::string> filesIn(const fs::path& folder) {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name == kHiddenName) continue;
    if (!entry.is_directory()) {
      names.push_back(name);
      continue;
    }
    std::error_code unreadable;
    for (const fs::directory_entry& inner : fs::directory_iterator(entry.path(), unreadable)) {
      if (!inner.is_directory()) names.push_back(name + "/" + inner.path().filename().string());
    }
  }
  std::ranges::sort(names);
  return names;
}

// Returns true if a split could have the folder's name, and if the folder is readable and contains no folders.
bool couldBeSplit(const fs::path& folder) {
  if (!isSplitName(folder.filename().string())) return false;
  std::error_code unreadable;
  const fs::directory_iterator inside(folder, unreadable);
  return !unreadable &&
         std::none_of(begin(inside), end(inside), [](const fs::directory_entry& e) { return e.is_directory(); });
}

}  // namespace

bool isUnfinished(const fs::path& folder) {
  return pathExists(folder / kHiddenName / kPlanName);
}

void requireDataset(const fs::path& folder, const std::string& alternatives) {
  std::error_code failure;
  if (fs::exists(folder / kManifestName, failure)) return;
  const auto refuse = [&](const std::string& why) { throw InputError({folder.string()}, why); };
  if (failure) refuse("cannot be read: " + failure.message());
  if (!fs::exists(folder, failure)) refuse("does not exist: name the folder of a dataset");
  if (!fs::is_directory(folder, failure)) refuse("is a file: name the folder of a dataset");
  if (recordingIn(folder)) {
    refuse(
        "is a recording, not a dataset: `scanmill generate --from-hits` or `--from-passes` makes scans from it, and "
        "checks each of its files");
  }
  if (isUnfinished(folder)) {
    refuse(
        fmt::format("has an unfinished dataset: `scanmill generate` writes {} last. Wait until it ends; if it was "
                    "stopped, `scanmill generate PIPELINE -o {} --resume` completes it, or the same loop in Python "
                    "with resume=True",
                    kManifestName, folder.string()));
  }
  refuse(fmt::format("is not a dataset: it has no {}, which `scanmill generate` writes last{}", kManifestName,
                     alternatives));
}

FolderContents contentsOf(const fs::path& folder) {
  FolderContents contents;
  contents.unfinished = isUnfinished(folder);
  for (const std::string& name : filesIn(folder)) {
    if (name == kManifestName) {
      contents.manifest = true;
    } else if (isShardName(name)) {
      contents.shards.push_back(name);
    } else if (isLeftover(name)) {
      contents.leftovers.push_back(name);
    } else if (contents.foreign.empty()) {
      contents.foreign = name;
    }
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().filename() == kHiddenName) continue;
    if (entry.is_directory() && contents.foreign.empty() && !couldBeSplit(entry.path())) {
      contents.foreign = entry.path().filename().string();
    }
  }
  return contents;
}

std::vector<std::string> filesListedIn(const fs::path& file) {
  if (!pathExists(file)) return {};
  std::vector<std::string> listed;
  try {
    for (const ShardRecord& shard : parseManifest(readFile(file), file.string()).shards) {
      listed.push_back(shard.file);
      if (!shard.samplesSha256.empty()) listed.push_back(samplesFileOf(shard.file));
    }
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("{}\n"
                    "so the files of that folder cannot be assigned to a dataset: remove them by hand, or choose "
                    "another output folder",
                    error.what()));
  }
  return listed;
}

std::vector<std::string> shardsRecordedIn(const fs::path& hidden) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(hidden, ignored)) {
    std::string name = entry.path().lexically_relative(hidden).generic_string();
    if (!name.ends_with(kRecordSuffix)) continue;
    name.resize(name.size() - std::strlen(kRecordSuffix));
    if (isShardName(name)) names.push_back(std::move(name));
  }
  return names;
}

std::set<std::string> writtenFiles(const fs::path& folder) {
  std::set<std::string> written;
  for (const fs::path& manifest : {folder / kManifestName, folder / kHiddenName / kReplacedName}) {
    for (const std::string& file : filesListedIn(manifest)) written.insert(file);
  }
  for (const std::string& shard : shardsRecordedIn(folder / kHiddenName)) {
    written.insert({shard, samplesFileOf(shard)});
  }
  return written;
}

void checkOwnership(const fs::path& folder, const FolderContents& contents) {
  const std::set<std::string> written = writtenFiles(folder);
  for (const std::string& name : contents.shards) {
    if (written.contains(name)) continue;
    throw InputError({(folder / name).string()}, "exists, but {}: move it, or choose another output folder",
                     contents.manifest ? "the manifest does not list it" : "no manifest lists it");
  }
  if (!contents.manifest && !contents.unfinished && !contents.foreign.empty()) {
    throw InputError({folder.string()},
                     "has no dataset of this program, but other files such as '{}': --overwrite replaces "
                     "only datasets; choose another output folder with -o",
                     contents.foreign);
  }
}

}  // namespace scanmill
