#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <map>

#include "base/append_new.h"
#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "config/resources.h"
#include "dataset/manifest.h"

namespace scanmill {

std::vector<FileRecord> recordsOf(const FilesRead& read, const std::filesystem::path& folder) {
  std::vector<FileRecord> files;
  for (const auto& [file, hash] : read.hashes()) files.push_back({savedPath(file, folder), hash});
  std::ranges::sort(files);
  return files;
}

std::string addFiles(const std::vector<FileRecord>& added, std::vector<FileRecord>& files) {
  files.insert(files.end(), added.begin(), added.end());
  std::ranges::sort(files);
  files.erase(std::unique(files.begin(), files.end()), files.end());
  const auto changed = std::ranges::adjacent_find(files, std::ranges::equal_to(), &FileRecord::file);
  return changed == files.end() ? std::string() : changed->file;
}

void requireUnchangedFiles(const std::vector<FileRecord>& files, const std::filesystem::path& folder,
                           const std::filesystem::path& dataset) {
  constexpr std::size_t kMostNamed = 5;  // files in the message
  std::vector<std::string> changed;
  std::map<std::filesystem::path, std::string> currentHashes;  // empty: the file is missing
  for (const FileRecord& record : files) {
    const std::filesystem::path file = fileOfSavedPath(record.file, folder);
    const auto [hash, isNew] = currentHashes.try_emplace(file);
    if (isNew && isFile(file)) hash->second = xxh3OfFile(file);
    if (hash->second != record.xxh3) appendNew({file.string()}, changed);
  }
  if (changed.empty()) return;
  const std::size_t named = std::min(kMostNamed, changed.size());
  const std::string unnamed = named < changed.size() ? fmt::format(" and {} more", changed.size() - named) : "";
  changed.resize(named);
  throw InputError({dataset.string()},
                   fmt::format("has shards that were made before these files changed or went: {}{}: restore the files, "
                               "add --overwrite to start again, or give --resume=anyway to keep these shards",
                               fmt::join(changed, ", "), unnamed));
}

}  // namespace scanmill
