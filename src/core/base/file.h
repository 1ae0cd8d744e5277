#pragma once

// Reads and writes whole files. A file that is written gets its final name only when it is complete.

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "base/descriptor.h"

namespace scanmill {

// Returns the bytes of a whole file. Throws an InputError that names the file if it is absent, a folder, unreadable or
// larger than the memory that is allowed.
std::string readFile(const std::filesystem::path& path);

// Reads a file as readFile() does, but block by block, and passes each block to `take`.
void readBlocks(const std::filesystem::path& path, const std::function<void(std::string_view)>& take);

// A file that is written under a temporary name in its folder, NAME.partial-PID-RANDOM-HOST, which no other process can
// have. commit() flushes it to the disk and gives it its final name, also where a link had this name. Without commit(),
// because of an exception or an early return, the destructor removes the temporary file, and a file of the final name
// stays as it was. The constructor, write(), flush() and commit() throw an Error with the path and the reason, such as
// "No space left on device".
class [[nodiscard]] AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& path) : AtomicFile(path.parent_path(), path) {}
  // Follows no links below `folder`, as described in base/own_folder.h; `path` begins with `folder`.
  AtomicFile(const std::filesystem::path& folder, std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view bytes);
  std::size_t size() const { return size_; }  // bytes written so far
  // Flushes the bytes to the disk, which may fail and take time. After flush(), commit() only renames the file and
  // flushes the folder.
  void flush();
  void commit();

 private:
  std::filesystem::path path_;
  std::string temporary_;  // name in the file's folder
  Descriptor place_;       // the file's folder
  Descriptor file_;
  std::size_t size_ = 0;
  bool flushed_ = false;
};

// Writes a complete file by an AtomicFile; the first function makes its folder, if that is missing. Throws Error as
// AtomicFile does.
void writeFile(const std::filesystem::path& path, std::string_view bytes);
void writeFile(const std::filesystem::path& folder, const std::filesystem::path& path, std::string_view bytes);

// Flushes a folder's list of names to the disk, so that new, renamed and removed files survive a power failure. Does
// nothing if the file system cannot flush folders or the folder is not readable. Throws Error for all other failures.
void syncFolder(const std::filesystem::path& folder);

}  // namespace scanmill
