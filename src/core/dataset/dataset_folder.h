#pragma once

// The folder that a dataset is written into.
//
// While a dataset is being made, all of it lies in the hidden folder .scanmill within: its whole shards, a small record
// beside each (parts.h), what is planned, and the locks of the processes that make it. Readers see nothing of that. At
// the end the shards are moved to their places, the manifest is written, and the hidden folder goes. A dataset that is
// to be replaced stays until then.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "base/folder_lock.h"
#include "dataset/manifest.h"
#include "dataset/parts.h"

namespace scanmill {

enum class FolderUse {
  New,      // an absent or an empty folder
  Replace,  // the dataset that is there, or an unfinished one
  Resume,   // the unfinished dataset that is there; without one, like New
  Share,    // the same, together with other processes that share it; or a dataset that these have ended, see isWhole()
};

class DatasetFolder {
 public:
  // Creates the folder. Throws InputError, and changes nothing, where the folder holds what `use` does not allow: a
  // dataset, files of others, names that shards would get, what another plan has begun; and where a process writes into
  // it that does not share it.
  DatasetFolder(std::filesystem::path folder, FolderUse use, DatasetPlan plan);
  // Gives the lock back. What is unfinished stays to be resumed, where it holds a whole shard or others work on it.
  ~DatasetFolder();
  DatasetFolder(const DatasetFolder&) = delete;
  DatasetFolder& operator=(const DatasetFolder&) = delete;

  // Throws what the constructor would throw of a folder that nobody writes into, and changes nothing.
  static void check(const std::filesystem::path& folder, FolderUse use);

  // Removes what a process has left over that died after it had written the manifest.
  static void tidy(const std::filesystem::path& folder);

  // What is planned of the unfinished dataset there. Throws InputError where there is none.
  static DatasetPlan planned(const std::filesystem::path& folder);

  // Of a shared folder: other processes have ended the dataset meanwhile. Then there is nothing to do.
  bool isWhole() const { return whole_; }

  // Where shards are written.
  const std::filesystem::path& staging() const { return staging_; }

  // Claims a shard for this process, as long as what is returned lives; null where another process holds it.
  std::unique_ptr<FolderLock> claim(const std::string& name);
  // Keeps the record of a shard that is whole in staging().
  void keep(const DatasetPart& part);
  enum class Check { Size, Bytes };
  // The record of a shard, where it was kept and the shard is there, by its size, or byte for byte by its hash. Throws
  // InputError for one of another plan. `name`: see shardName().
  std::optional<DatasetPart> kept(const std::string& name, Check check) const;

  // Of a shared folder: false, and the folder is left to the others, where other processes work on it. Must come before
  // publish().
  bool makeAlone();
  // Moves the shards of the manifest, all of which are kept, to their places, in place of those of an earlier dataset,
  // and writes the manifest last. Descriptions of samples that would take more than so many bytes in all go to files
  // beside the shards. Throws Error where the disk fails, or where the folder is not the one that
  // it was; then the dataset can be resumed.
  void publish(const Manifest& manifest, std::uint64_t mostSampleBytes = 100'000'000);
  // Throws Error where the folder was removed or replaced since this object was made.
  void checkPlace() const;

 private:
  void begin(FolderUse use);
  void share();
  void leave();
  std::filesystem::path placeOf(const std::string& name) const;

  std::filesystem::path folder_;
  std::filesystem::path staging_;
  std::pair<std::uint64_t, std::uint64_t> place_{0, 0};  // what the file system knows the folder by
  DatasetPlan plan_;
  std::unique_ptr<FolderLock> lock_;
  bool shared_ = false;
  bool whole_ = false;
  bool created_ = false;  // the folder, by this object
  bool published_ = false;
};

}  // namespace scanmill
