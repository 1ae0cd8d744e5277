#include "base/files_read.h"

#include "base/hash.h"

namespace scanmill {

namespace {

thread_local FilesRead* latest = nullptr;

std::filesystem::path cleanPath(const std::filesystem::path& file) {
  return std::filesystem::absolute(file).lexically_normal();
}

}  // namespace

FilesRead::FilesRead() : outer_(latest) {
  latest = this;
}

FilesRead::~FilesRead() {
  latest = outer_;
}

std::map<std::filesystem::path, std::string> FilesRead::hashes() const {
  std::map<std::filesystem::path, std::string> all = hashes_;
  std::erase_if(all, [](const auto& entry) {  // readers go on without some files that are missing, such as textures
    std::error_code ignored;
    return !std::filesystem::is_regular_file(entry.first, ignored);
  });
  for (auto& [file, hash] : all) {
    if (hash.empty()) hash = xxh3OfFile(file);
  }
  return all;
}

void noteFile(const std::filesystem::path& file) {
  if (latest != nullptr) latest->hashes_.try_emplace(cleanPath(file));
}

void noteFile(const std::filesystem::path& file, std::string_view bytes) {
  if (latest != nullptr) latest->hashes_[cleanPath(file)] = xxh3(bytes);
}

}  // namespace scanmill
