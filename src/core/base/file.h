#pragma once

// Whole files, read and written so that a file under its final name is always complete.

#include <filesystem>
#include <string>
#include <string_view>

namespace scanmill {

// The whole file. Throws InputError that names it where it is absent, a folder or unreadable.
std::string readFile(const std::filesystem::path& path);

// Writes to a temporary name in the same folder, then fsync and rename on commit(). Without commit() (an exception, an
// early return) the temporary is removed and the final name is untouched. Throws Error with the path and the reason,
// such as "No space left on device".
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::string_view bytes);
  std::size_t size() const { return size_; }
  void commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path temporary_;
  int descriptor_ = -1;
  std::size_t size_ = 0;
};

// One AtomicFile, written and committed.
void writeFile(const std::filesystem::path& path, std::string_view bytes);

}  // namespace scanmill
