#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

// A folder that lives as long as the object. Its name has no words: drafts of scenes guess from the names of folders.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    // Other tests come and go meanwhile, and may have left a folder of that number.
    const auto first = static_cast<unsigned>(::getpid());
    std::error_code failure;
    for (unsigned number = first; number < first + 1000; ++number) {
      path_ = std::filesystem::temp_directory_path() / ("scanmill-test-" + std::to_string(number));
      if (std::filesystem::create_directory(path_, failure)) return;
    }
    throw std::filesystem::filesystem_error("no temporary folder", path_, failure);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

  // Writes a file (folders are made) and gives its path.
  std::filesystem::path write(const std::string& name, std::string_view text) const {
    const std::filesystem::path file = path_ / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
    return file;
  }

 private:
  std::filesystem::path path_;
};
