#pragma once

// Locks that decide which processes may write into a folder.

#include <filesystem>
#include <memory>
#include <string>

#include "base/own_folder.h"

namespace scanmill {

enum class LockKind {
  Alone,   // no other process holds the lock
  Shared,  // no process holds the lock alone
};

// Holds a lock file. The destructor removes the file if it is certain that no other process holds the lock. The file
// states which process took the lock last, on which host, and since when. The lock is the operating system's (flock; on
// network file systems Linux turns it into a lock of the server). A process that dies therefore loses the lock and
// leaves only a file that nobody holds. On a file system without locks, a shared lock keeps no process out, and an
// exclusive lock counts as held if the process that the file names still runs on this host or ran on another host.
class [[nodiscard]] FolderLock {
 public:
  // `folder` must exist and may be a link; error messages name this path. `file` lies in `folder` or in folders below
  // it, none of which may be a link (base/own_folder.h). Throws an InputError that names the holder if another process
  // holds the lock, ForeignFile if the file is a link, a folder, a pipe or device, or a file with a second hard link,
  // and Error if the file cannot be created or written.
  FolderLock(const std::filesystem::path& folder, const std::filesystem::path& file, LockKind kind = LockKind::Alone);
  ~FolderLock();
  FolderLock& operator=(FolderLock&&) = delete;  // neither copied nor moved

  // Does the same as the constructor, but returns null if another process holds the lock, which `holder` then names.
  [[nodiscard]] static std::unique_ptr<FolderLock> tryTake(const std::filesystem::path& folder,
                                                           const std::filesystem::path& file, LockKind kind,
                                                           std::string& holder);

  // Turns a shared lock into an exclusive lock. Returns false and loses the lock if another process shares it, or if
  // the file system has no locks.
  [[nodiscard]] bool makeAlone();
  // True if the lock keeps other processes out: false on a file system without locks.
  bool keepsOthersOut() const { return locked_; }

 private:
  FolderLock() = default;
  // Takes the lock as tryTake() does. Returns false and sets `holder` if another process holds the lock.
  [[nodiscard]] bool take(const std::filesystem::path& folder, const std::filesystem::path& file, LockKind kind,
                          std::string& holder);
  void open();
  void writeLockText();
  bool isStillThere() const;
  void remove() const;

  std::filesystem::path folder_;
  std::filesystem::path file_;
  LockKind kind_ = LockKind::Alone;
  bool locked_ = false;    // true: the operating system holds the lock; false: the file system has no locks
  Descriptor descriptor_;  // the lock file; closing it releases the lock
};

}  // namespace scanmill
