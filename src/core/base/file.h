#pragma once

// Whole files, read and written so that a file under its final name is always complete.

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace scanmill {

// Returns the bytes of a whole file. Throws an InputError that names the file where it is absent, a folder or
// unreadable.
std::string readFile(const std::filesystem::path& path);

// Does the same piece by piece, each of which `take` gets.
void readBlocks(const std::filesystem::path& path, const std::function<void(std::string_view)>& take);

// A file that is written under a temporary name in its folder. commit() flushes it to the disk and gives it its final
// name. Without commit(), be it for an exception or an early return, the temporary file is removed, and what has the
// final name stays as it is. All calls throw an Error with the path and the reason, such as "No space left on device".
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view bytes);
  std::size_t size() const { return size_; }  // bytes written so far
  // To the disk, which may fail and take time: what commit() does afterwards is no more than to rename.
  void flush();
  void commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path temporary_;
  int descriptor_ = -1;
  std::size_t size_ = 0;
  bool flushed_ = false;
};

// Writes and commits an AtomicFile. Throws Error as that does.
void writeFile(const std::filesystem::path& path, std::string_view bytes);

// Renames a file, in place of one that is there; creates the folder that it goes to. Both on one file system. Throws
// Error.
void moveFile(const std::filesystem::path& from, const std::filesystem::path& to);

// Makes removals and new names in a folder durable. Throws Error, but for file systems that cannot do that to folders.
void syncFolder(const std::filesystem::path& folder);

}  // namespace scanmill
