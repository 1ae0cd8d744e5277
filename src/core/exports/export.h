#pragma once

// Exports a dataset to another layout.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "exports/layout.h"

namespace scanmill {

struct ExportOptions {
  std::filesystem::path dataset;  // folder of the dataset
  const LayoutEntry* layout = nullptr;
  std::filesystem::path folder;        // the output folder: absent or empty, or with an export to replace
  std::filesystem::path classes;       // file of an ontology that replaces the layout's; empty: the layout's ontology
  std::vector<std::string> sensors{};  // names; empty: all, or only the first if the layout allows only one
  std::vector<std::string> splits{};   // names; empty: all
  RosNames ros{};                      // only for MCAP
  bool overwrite = false;              // true: replaces an export in the folder, complete or not
  const std::atomic<bool>* stop = nullptr;
  // Called from any thread after each read frame. `done`, `all`: numbers of frames in `stage` (checking or writing).
  std::function<void(const char* stage, std::uint64_t done, std::uint64_t all)> progress{};
};

struct ExportSummary {
  std::uint64_t sequences = 0;
  std::uint64_t frames = 0;
  std::vector<std::string> warnings;
};

// Exports a dataset. Each thread has only one frame in memory at a time. Throws InputError, before the first file is
// written, if the dataset does not fit the layout; throws Error if the disk fails or `stop` becomes true. An unfinished
// export stays, and a later call with `overwrite` replaces it.
ExportSummary exportDataset(const ExportOptions& options);

}  // namespace scanmill
