#pragma once

// The whole way: shots -> hits -> effects -> scans -> bytes -> shards -> manifest.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/stage_clock.h"
#include "dataset/manifest.h"
#include "pipeline/plan/plan.h"

namespace scanmill {

struct GenerateOptions {
  std::filesystem::path folder;
  std::filesystem::path keepHits;    // folder of a recording, or empty
  std::filesystem::path keepPasses;  // likewise; methods that draw passes only
  bool overwrite = false;            // the dataset, and recordings
  bool resume = false;               // goes on with an unfinished dataset; not with recordings
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;  // set by a signal handler: generate() then throws Error
};

struct GenerateSummary {
  Manifest manifest;
  double seconds = 0;
  std::uint64_t beams = 0;
  std::uint64_t points = 0;
  std::uint64_t bytes = 0;
  std::map<std::uint16_t, std::uint64_t> pointsPerClass;
  StageSeconds stages;                // of processor time ("trace", "effects", "encode", "write", ...)
  std::size_t resumedShards = 0;      // that were whole already
  std::vector<std::string> warnings;  // what is legal, but seldom meant: see pipeline/warnings.h
};

// Throws InputError for an unusable scene or folder, Error where the work fails. Without a manifest nothing in the
// folder counts as a dataset; what is unfinished can be resumed, and gives the same bytes (see dataset_folder.h).
GenerateSummary generate(const Plan& plan, const GenerateOptions& options);

}  // namespace scanmill
