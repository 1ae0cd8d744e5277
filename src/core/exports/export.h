#pragma once

// Writes a dataset in another layout.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "exports/layout.h"

namespace scanmill {

struct ExportOptions {
  std::filesystem::path dataset;  // its folder
  const LayoutEntry* layout = nullptr;
  std::filesystem::path folder;        // that is written: absent, empty, or of an export that is resumed
  std::filesystem::path classes;       // an ontology's file in place of the layout's; empty: that
  std::vector<std::string> sensors{};  // empty: all, or the first where the layout holds one
  std::vector<std::string> splits{};   // empty: all
  bool resume = false;
  const std::atomic<bool>* stop = nullptr;
  // Called, by any thread, when a frame is read to be checked or written.
  std::function<void(const char* stage, std::uint64_t done, std::uint64_t all)> progress{};
};

struct ExportSummary {
  std::uint64_t sequences = 0;
  std::uint64_t frames = 0;
  std::uint64_t resumedFrames = 0;  // that were there before
  std::vector<std::string> warnings;
};

// Streams: of each thread one frame is in memory. Throws InputError for what does not fit, before the first file is
// written, and Error where the disk fails or `stop` is set; what was written stays, and `resume` goes on with it.
ExportSummary exportDataset(const ExportOptions& options);

}  // namespace scanmill
