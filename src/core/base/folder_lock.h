#pragma once

// Which processes may write into a folder.

#include <filesystem>
#include <memory>
#include <string>

#include "base/error.h"

namespace scanmill {

// In the place of a lock file lies something that this program did not make: a link, a folder, or a file that has
// another name as well. It is left as it is, and so is what a link names. The text says what to remove.
class ForeignFile : public InputError {
 public:
  using InputError::InputError;
};

enum class LockKind {
  Alone,   // no other process holds the lock
  Shared,  // none holds it alone
};

// Holds a lock file until it is destroyed, which removes it where it is known that no other process holds it. The file
// says which process has taken it last, on which host, since when. The lock is the operating system's (flock; Linux
// makes it one of the server's on network file systems), so that a process which dies loses it and leaves no more than
// a file that nobody holds. Where the file system knows no locks, nobody can be kept from sharing, and a file that was
// taken alone counts as held if its process runs on this host, or was made on another one.
class FolderLock {
 public:
  // `folder` is there already; it may be a link, and is named in errors. `file` lies in it or in folders of it, none of
  // which may be a link. Throws an InputError that says who holds the lock, ForeignFile, and Error where the file
  // cannot be made.
  FolderLock(const std::filesystem::path& folder, const std::filesystem::path& file, LockKind kind = LockKind::Alone);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  // The same as the constructor, but gives null where another process holds it, and says which in `holder`.
  static std::unique_ptr<FolderLock> tryTake(const std::filesystem::path& folder, const std::filesystem::path& file,
                                             LockKind kind, std::string& holder);

  // From shared to alone; false, and the lock is lost, where another process holds it as well, or where nobody can
  // know.
  bool makeAlone();
  // Whether others are kept out: not where the file system knows no locks.
  bool isKept() const { return locked_; }

 private:
  FolderLock() = default;
  bool take(const std::filesystem::path& folder, const std::filesystem::path& file, LockKind kind, std::string& holder);
  bool isStillThere() const;
  void remove() const;
  void release();

  std::filesystem::path folder_;
  std::filesystem::path file_;
  LockKind kind_ = LockKind::Alone;
  bool locked_ = false;
  int descriptor_ = -1;
};

}  // namespace scanmill
