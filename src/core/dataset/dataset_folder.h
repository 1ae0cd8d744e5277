#pragma once

// The folder that a dataset is written into.
//
// While a dataset is being made, all of it lies in the hidden folder .scanmill within: its whole shards, a small record
// beside each, what it is made of, and the lock of the process that makes it. Readers see nothing of that. At the end
// the shards are moved to their places, the manifest is written, and the hidden folder goes. A dataset that is to be
// replaced stays until then.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "base/folder_lock.h"
#include "dataset/manifest.h"

namespace scanmill {

enum class FolderUse {
  New,      // an absent or an empty folder
  Replace,  // the dataset that is there, or an unfinished one
  Resume,   // the unfinished dataset that is there; without one, like New
};

class DatasetFolder {
 public:
  // `plan`: a text without line breaks that differs where what is made differs, such as a hash. Creates the folder.
  // Throws InputError, and changes nothing, where the folder holds what `use` does not allow: a dataset, files of
  // others, names that shards would get, what another plan has begun; and where another process writes into it.
  DatasetFolder(std::filesystem::path folder, FolderUse use, const std::string& plan);
  // Gives the lock back. What is unfinished stays to be resumed, where it holds a whole shard.
  ~DatasetFolder();
  DatasetFolder(const DatasetFolder&) = delete;
  DatasetFolder& operator=(const DatasetFolder&) = delete;

  // Throws what the constructor would throw of a folder that nobody writes into, and changes nothing.
  static void check(const std::filesystem::path& folder, FolderUse use);

  // Whether somebody has begun a dataset there, and not ended it.
  static bool isUnfinished(const std::filesystem::path& folder);

  // Where shards are written.
  const std::filesystem::path& staging() const { return staging_; }

  // Keeps the record of a shard that is whole in staging(): a manifest with that shard and its samples alone.
  void keep(const Manifest& part);
  // The record of a shard, where it was kept and the shard is there byte for byte. `name`: see shardName().
  std::optional<Manifest> kept(const std::string& name) const;

  // Moves the shards of the manifest, all of which are kept, to their places, in place of those of an earlier dataset,
  // and writes the manifest last. Throws Error where the disk fails; then the dataset can be resumed.
  void publish(const Manifest& manifest);

 private:
  std::filesystem::path whole(const std::string& name) const;

  std::filesystem::path folder_;
  std::filesystem::path staging_;
  std::unique_ptr<FolderLock> lock_;
  bool created_ = false;  // the folder, by this object
  bool published_ = false;
};

}  // namespace scanmill
