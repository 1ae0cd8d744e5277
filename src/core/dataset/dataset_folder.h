#pragma once

// The folder that a dataset is written into.
//
// Until a dataset is complete, all its files are in the hidden subfolder .scanmill: its complete shards, a small record
// beside each shard (parts.h), the plan, and the locks of the processes that write the dataset. Readers ignore this
// folder. At the end the shards are moved to their final paths, the manifest is written, and the hidden folder is
// removed. An existing dataset that is replaced stays until that moment.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/folder_lock.h"
#include "dataset/manifest.h"
#include "dataset/parts.h"

namespace scanmill {

enum class FolderUse {
  New,      // the folder must be absent or empty
  Replace,  // replaces the dataset in the folder, whether it is complete or unfinished
  Resume,   // continues the unfinished dataset in the folder; like New if the folder has none
  Share,    // like Resume, but several processes may write, and the dataset may already be complete, see isComplete()
};

class DatasetFolder {
 public:
  // Creates the folder. Throws InputError, and changes nothing, if the folder contains something that `use` does not
  // allow: a dataset, files of other programs, files with the names of shards, or an unfinished dataset of another
  // plan. Also throws InputError if another process is writing into the folder, unless both processes use Share.
  DatasetFolder(std::filesystem::path folder, FolderUse use, DatasetPlan plan);
  // Releases the lock. An unfinished dataset stays on the disk, so that it can be resumed, if it has a complete shard
  // or if other processes are working on it.
  ~DatasetFolder();
  DatasetFolder& operator=(DatasetFolder&&) = delete;  // neither copied nor moved

  // Makes the constructor's checks, except the comparison of plans, and throws the same errors. Changes no dataset.
  static void check(const std::filesystem::path& folder, FolderUse use);

  // Removes the hidden folder of a complete dataset, which a process leaves if it is killed after writing the manifest.
  static void tidy(const std::filesystem::path& folder);

  // Returns the plan of the unfinished dataset in the folder. Throws InputError if the folder has none.
  static DatasetPlan planned(const std::filesystem::path& folder);

  // Returns true if other processes that share the folder have already completed the dataset, so that nothing remains
  // to be done.
  bool isComplete() const { return complete_; }

  // Returns the folder into which shards are written.
  const std::filesystem::path& staging() const { return staging_; }

  // Claims a shard for this process while the returned lock exists. Returns null if another process has claimed it.
  [[nodiscard]] std::unique_ptr<FolderLock> claim(const std::string& name);
  // Stores the record of a shard that is complete in staging().
  void storeRecord(const DatasetPart& part);
  // Returns true if any shard of the dataset is complete, whichever process made it.
  bool hasRecords() const;
  enum class Check { Size, Bytes };
  // Returns the record of a shard, if a record was stored and the shard has the recorded size and (with Check::Bytes)
  // the recorded hash; otherwise nothing. `name`: see shardName(). Throws InputError if the record belongs to another
  // plan.
  std::optional<DatasetPart> findRecord(const std::string& name, Check check) const;

  // Takes exclusive ownership of the folder. Returns false and gives up the lock if other processes that share the
  // folder are still writing into it. Must be called before publish().
  [[nodiscard]] bool makeAlone();
  // Moves the shards of the manifest, all of which must have records, to their final paths, replaces the shards of an
  // earlier dataset, and finally writes the manifest. If the descriptions of all samples take more than
  // `mostSampleBytes`, they are written to files beside the shards. The data card and the metadata of card.h are
  // written, too. Throws Error if the disk fails, or if the folder was removed or replaced; the dataset can then be
  // resumed.
  void publish(const Manifest& manifest, std::uint64_t mostSampleBytes = 100'000'000);
  // Throws Error if the folder was removed or replaced since this object was created.
  void requireSameFolder() const;

 private:
  // Identifies a folder independently of its path, so that a replacement at the same path is noticed.
  struct Identity {
    std::uint64_t device = 0, inode = 0;
    int error = 0;  // the system's error number if the folder cannot be examined, such as ENOENT; 0: none
    bool operator==(const Identity&) const = default;
  };
  static Identity identityOf(const std::filesystem::path& path);

  void share();
  void leave();
  std::unique_ptr<FolderLock> lockStart() const;
  void writeOrMatchPlan(FolderUse use);
  void removeReplaced() const;
  void writeChecked(std::string_view name, const std::string& bytes, const std::function<void()>& check) const;
  std::filesystem::path shardPath(const std::string& name) const;

  std::filesystem::path folder_;
  std::filesystem::path staging_;
  Identity identity_;  // identity of the folder when this object was created
  DatasetPlan plan_;
  std::unique_ptr<FolderLock> lock_;
  bool shared_ = false;    // FolderUse::Share: other processes may write into the folder, too
  bool complete_ = false;  // true if other processes had already completed the dataset
  bool created_ = false;   // true if this object has created the folder
  bool published_ = false;
};

}  // namespace scanmill
