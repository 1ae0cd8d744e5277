#pragma once

#include <filesystem>

namespace scanmill {

// A new folder among the system's temporary ones (TMPDIR, or /tmp), for this user alone; gone with the object.
class ScratchFolder {
 public:
  ScratchFolder();  // throws Error
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace scanmill
