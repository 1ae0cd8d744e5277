#pragma once

#include <filesystem>

namespace scanmill {

// Makes a new temporary folder in TMPDIR, or in /tmp where that is not set. Only this user may enter it. The destructor
// removes it with all that is in it.
class ScratchFolder {
 public:
  ScratchFolder();  // throws Error where the folder cannot be made
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace scanmill
