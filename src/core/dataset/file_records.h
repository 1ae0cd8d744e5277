#pragma once

// The files that a dataset was made from. This header is installed because dataset/manifest.h includes it.
//
//   for (const FileRecord& file : readManifest("out/quickstart").files) std::puts(file.file.c_str());

#include <filesystem>
#include <string>
#include <vector>

#include "base/input_budget.h"

namespace scanmill {

struct FileRecord {
  std::string file;  // path, as savedPath() gives it
  std::string xxh3;  // hash of the file's bytes
  auto operator<=>(const FileRecord&) const = default;
};

// Returns the records of files. `folder`: the folder of the pipeline file.
std::vector<FileRecord> recordsOf(const FilesRead& read, const std::filesystem::path& folder);

// Adds records to a list and sorts it. Returns the first file in it that has two different hashes; empty if there is
// none.
std::string addFiles(const std::vector<FileRecord>& more, std::vector<FileRecord>& files);

// Throws InputError at `dataset` if any of the files has other bytes now, or is missing; the message names these files.
void requireUnchangedFiles(const std::vector<FileRecord>& files, const std::filesystem::path& folder,
                           const std::filesystem::path& dataset);

}  // namespace scanmill
