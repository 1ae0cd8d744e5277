#pragma once

// Reads files, writes files that get their final name only when they are complete, and creates temporary folders.

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

namespace scanmill {

// Owns a file descriptor and closes it. `number` is negative if opening the file failed, and after close().
struct [[nodiscard]] Descriptor {
  explicit Descriptor(int opened = -1) : number(opened) {}
  ~Descriptor() { close(); }
  Descriptor(Descriptor&& other) noexcept : number(std::exchange(other.number, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number, other.number);
    return *this;
  }
  bool open() const { return number >= 0; }
  void close();
  int number;
};

// These three functions also return false if the system reports an error. They are inline, since modules use them.
inline bool pathExists(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}
inline bool isFile(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}
inline bool isFolder(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

// Returns the bytes of a whole file. Throws an InputError that names the file if it is absent, a folder, unreadable or
// larger than the memory that is allowed.
std::string readFile(const std::filesystem::path& path);

// Reads a file as readFile() does, but block by block: calls visit(bytes) for each block.
void readBlocks(const std::filesystem::path& path, const std::function<void(std::string_view)>& visit);

// A file that is written under a temporary name in its folder, NAME.partial-PID-RANDOM-HOST, which no other process can
// have. commit() flushes the file to the disk and gives it its final name; a link of this name is replaced. Without
// commit(), because of an exception or an early return, the destructor removes the temporary file, and a file of the
// final name stays as it was. The constructor, write(), flush() and commit() throw an Error with the path and the
// reason, such as "No space left on device".
class [[nodiscard]] AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& path) : AtomicFile(path.parent_path(), path) {}
  // Follows no links below `folder`, as described in base/own_folder.h; `path` begins with `folder`.
  AtomicFile(const std::filesystem::path& folder, std::filesystem::path path);
  ~AtomicFile();
  AtomicFile& operator=(AtomicFile&&) = delete;  // neither copied nor moved

  void write(std::string_view bytes);
  // Replaces the first bytes of the file, which write() has written: a header whose counts are known at the end.
  void rewriteStart(std::string_view bytes);
  std::size_t size() const { return size_; }  // bytes written so far
  // Flushes the bytes to the disk, which may fail or be slow. A later commit() only renames the file and flushes the
  // folder.
  void flush();
  void commit();

 private:
  std::filesystem::path path_;
  std::string temporary_;  // name in the file's folder
  Descriptor folder_;      // the file's folder
  Descriptor file_;
  std::size_t size_ = 0;
  bool flushed_ = false;
};

// Write a complete file through an AtomicFile; the first function also creates missing folders. Throw Error as
// AtomicFile does.
void writeFile(const std::filesystem::path& path, std::string_view bytes);
void writeFile(const std::filesystem::path& folder, const std::filesystem::path& path, std::string_view bytes);

// Flushes a folder's list of names to the disk, so that new, renamed and removed files survive a power failure. Does
// nothing if the file system cannot flush folders or the folder is not readable. Throws Error for all other failures.
void syncFolder(const std::filesystem::path& folder);

// Creates a new temporary folder in TMPDIR, or in /tmp where TMPDIR is not set. Only this user may enter it. The
// destructor removes the folder with everything in it.
class [[nodiscard]] ScratchFolder {
 public:
  ScratchFolder();  // throws Error if the folder cannot be created
  ~ScratchFolder();
  ScratchFolder& operator=(ScratchFolder&&) = delete;  // neither copied nor moved

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace scanmill
