#include "dataset/file_records.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "base/append_new.h"
#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "config/resources.h"

namespace scanmill {

std::vector<FileRecord> recordsOf(const FilesRead& read, const std::filesystem::path& folder) {
  std::vector<FileRecord> files;
  for (const auto& [file, hash] : read.hashes()) files.push_back({savedPath(file, folder), hash});
  std::ranges::sort(files);
  return files;
}

std::string addFiles(const std::vector<FileRecord>& more, std::vector<FileRecord>& files) {
  files.insert(files.end(), more.begin(), more.end());
  std::ranges::sort(files);
  files.erase(std::unique(files.begin(), files.end()), files.end());
  const auto twice =
      std::ranges::adjacent_find(files, [](const FileRecord& a, const FileRecord& b) { return a.file == b.file; });
  return twice == files.end() ? std::string() : twice->file;
}

void requireUnchangedFiles(const std::vector<FileRecord>& files, const std::filesystem::path& folder,
                           const std::filesystem::path& dataset) {
  constexpr std::size_t kNamed = 5;
  std::vector<std::string> changed;
  std::map<std::filesystem::path, std::string> now;  // hashes; empty: the file is missing
  for (const FileRecord& record : files) {
    const std::filesystem::path file = fileOfSavedPath(record.file, folder);
    const auto [hash, isNew] = now.try_emplace(file);
    if (isNew && isFile(file)) hash->second = xxh3OfFile(file);
    if (hash->second != record.xxh3) appendNew({file.string()}, changed);
  }
  if (changed.empty()) return;
  const std::size_t named = std::min(kNamed, changed.size());
  const std::string more = named < changed.size() ? fmt::format(" and {} more", changed.size() - named) : "";
  changed.resize(named);
  throw InputError({dataset.string()},
                   fmt::format("has shards that were made before these files changed or went: {}{}: restore the files, "
                               "add --overwrite to start again, or give --resume=anyway to keep these shards",
                               fmt::join(changed, ", "), more));
}

}  // namespace scanmill
