#include "dataset/output_folder.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "dataset/manifest.h"
#include "dataset/shard_name.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

struct EarlierRun {
  bool manifest = false;
  std::vector<std::string> shards;     // relative names
  std::vector<std::string> leftovers;  // relative names
  std::string foreign;                 // the first name, by its letters, of what is neither; empty where there is none
};

// Names of plain files in the folder and one level below, relative, sorted.
std::vector<std::string> filesIn(const fs::path& folder) {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_directory()) {
      names.push_back(name);
      continue;
    }
    std::error_code unreadable;
    for (const fs::directory_entry& inner : fs::directory_iterator(entry.path(), unreadable)) {
      if (!inner.is_directory()) names.push_back(name + "/" + inner.path().filename().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

// A folder with a split's name that holds no folders.
bool couldBeSplit(const fs::path& folder) {
  if (!isSplitName(folder.filename().string())) return false;
  std::error_code unreadable;
  const fs::directory_iterator inside(folder, unreadable);
  return !unreadable &&
         std::none_of(begin(inside), end(inside), [](const fs::directory_entry& e) { return e.is_directory(); });
}

EarlierRun earlierRunIn(const fs::path& folder) {
  EarlierRun run;
  for (const std::string& name : filesIn(folder)) {
    if (name == kManifestName) {
      run.manifest = true;
    } else if (isShardName(name)) {
      run.shards.push_back(name);
    } else if (isLeftover(name)) {
      run.leftovers.push_back(name);
    } else if (run.foreign.empty()) {
      run.foreign = name;
    }
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory() && run.foreign.empty() && !couldBeSplit(entry.path())) {
      run.foreign = entry.path().filename().string();
    }
  }
  return run;
}

// Refuses what an overwriting run would destroy without having written it.
void checkOwnership(const fs::path& folder, const EarlierRun& run) {
  if (!run.manifest) {
    if (run.foreign.empty()) return;
    throw InputError({folder.string()},
                     fmt::format("holds no dataset of this program, but files of others such as '{}': --overwrite "
                                 "replaces datasets only; choose another output folder with -o",
                                 run.foreign));
  }
  const fs::path file = folder / kManifestName;
  std::vector<std::string> listed;
  try {
    for (const ShardRecord& shard : parseManifest(readFile(file), file.string()).shards) listed.push_back(shard.file);
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("{}\nso what is in that folder cannot be told apart: remove it by hand, or choose "
                    "another output folder",
                    error.what()));
  }
  std::sort(listed.begin(), listed.end());
  for (const std::string& name : run.shards) {
    if (!std::binary_search(listed.begin(), listed.end(), name)) {
      throw InputError({(folder / name).string()},
                       "is in the way, and the manifest there does not list it: move it, or choose another output "
                       "folder");
    }
  }
}

void removeFile(const fs::path& file) {
  if (::unlink(file.c_str()) != 0 && errno != ENOENT) {
    throw Error(fmt::format("{}: cannot be removed: {}", file.string(), std::strerror(errno)));
  }
}

// Makes a removal durable: the entry lives in the folder.
void syncFolder(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

void removeEarlierRun(const fs::path& folder, const EarlierRun& run) {
  if (run.manifest) {
    removeFile(folder / kManifestName);
    syncFolder(folder);
  }
  for (const std::vector<std::string>* names : {&run.shards, &run.leftovers}) {
    for (const std::string& name : *names) {
      const fs::path file = folder / name;
      removeFile(file);
      std::error_code notEmpty;
      if (file.parent_path() != folder) fs::remove(file.parent_path(), notEmpty);
    }
  }
}

}  // namespace

void prepareOutputFolder(const fs::path& folder, bool overwrite) {
  try {
    if (fs::exists(folder) && !fs::is_directory(folder)) {
      throw InputError({folder.string()}, "is a file: choose another output folder");
    }
    fs::create_directories(folder);
    const EarlierRun run = earlierRunIn(folder);
    // Split folders that a stopped run left behind, and nothing in them.
    const bool empty = !run.manifest && run.foreign.empty() && run.shards.empty() && run.leftovers.empty();
    if (!empty && !overwrite) {
      throw InputError({folder.string()},
                       "exists and is not empty: add --overwrite to replace the dataset in it, or choose another "
                       "output folder with -o");
    }
    checkOwnership(folder, run);
    removeEarlierRun(folder, run);
  } catch (const fs::filesystem_error& error) {
    throw InputError({folder.string()}, "cannot be used as output folder: " + error.code().message());
  }
}

}  // namespace scanmill
