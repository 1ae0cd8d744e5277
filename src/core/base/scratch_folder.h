#pragma once

#include <filesystem>

namespace scanmill {

// Creates a new temporary folder in TMPDIR, or in /tmp where TMPDIR is not set. Only this user may enter it. The
// destructor removes the folder with everything in it.
class [[nodiscard]] ScratchFolder {
 public:
  ScratchFolder();  // throws Error if the folder cannot be created
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace scanmill
