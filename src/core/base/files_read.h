#pragma once

// Collects which files a thread reads, with hashes of their bytes.
//
//   const FilesRead read;
//   const Scene scene = readScene("scenes/yard.yaml", {});
//   for (const auto& [file, hash] : read.hashes()) std::printf("%s  %s\n", hash.c_str(), file.c_str());

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace scanmill {

// While such an object lives on a thread, it collects the files that this thread reads. A second object on the thread
// takes the files from the first one as long as it lives.
class [[nodiscard]] FilesRead {
 public:
  FilesRead();
  ~FilesRead();
  FilesRead(const FilesRead&) = delete;
  FilesRead& operator=(const FilesRead&) = delete;

  // Returns the XXH3 of each file, see xxh3(), by its absolute path. Reads files again that libraries have read.
  std::map<std::filesystem::path, std::string> hashes() const;

 private:
  friend void noteFile(const std::filesystem::path& file);
  friend void noteFile(const std::filesystem::path& file, std::string_view bytes);

  std::map<std::filesystem::path, std::string> hashes_;  // an empty hash is not computed yet
  FilesRead* outer_;
};

// Tell the thread's latest FilesRead that a file is read, the second one with the file's bytes. readFile() and
// chargeFile() call them; readers that leave the reading to a library call the first one.
void noteFile(const std::filesystem::path& file);
void noteFile(const std::filesystem::path& file, std::string_view bytes);

}  // namespace scanmill
