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
  std::filesystem::path folder;        // the output: absent, empty, or with an unfinished export to resume
  std::filesystem::path classes;       // file of an ontology in place of the layout's; empty: the layout's
  std::vector<std::string> sensors{};  // empty: all, or the first if the layout holds only one
  std::vector<std::string> splits{};   // empty: all
  bool resume = false;
  const std::atomic<bool>* stop = nullptr;
  // Called, from any thread, each time that a frame has been read to be checked or written.
  std::function<void(const char* stage, std::uint64_t done, std::uint64_t all)> progress{};
};

struct ExportSummary {
  std::uint64_t sequences = 0;
  std::uint64_t frames = 0;
  std::uint64_t resumedFrames = 0;  // frames that an earlier run has written
  std::vector<std::string> warnings;
};

// Each thread holds only one frame in memory at a time. Throws InputError, before the first file is written, if the
// dataset does not fit the layout, and Error if the disk fails or `stop` is set. Written files stay, and `resume`
// continues after them.
ExportSummary exportDataset(const ExportOptions& options);

}  // namespace scanmill
