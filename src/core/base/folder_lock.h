#pragma once

// One process at a time may write into a folder.

#include <filesystem>

namespace scanmill {

// Holds a lock file until it is destroyed, which removes it. The file says which process holds it, on which host, since
// when. The lock is the operating system's (flock; Linux makes it one of the server's on network file systems), so that
// a process which dies loses it and leaves no more than a file that nobody holds. Where the file system knows no locks,
// a file whose process runs on this host, or was made on another one, is taken for held.
class FolderLock {
 public:
  // `folder` is there already; it is named in errors. Throws an InputError that says who holds it, and Error where the
  // file cannot be made.
  FolderLock(const std::filesystem::path& folder, const std::filesystem::path& file);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

}  // namespace scanmill
