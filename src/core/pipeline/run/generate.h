#pragma once

// Makes the dataset of a plan: shots -> hits -> effects -> scans -> bytes -> shards -> manifest.
//
//   const GenerateSummary made = generate(plan, {.folder = "out/street", .quiet = true});
//   std::printf("%zu samples, %llu points\n", made.samples, static_cast<unsigned long long>(made.points));

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/stage_clock.h"
#include "dataset/manifest.h"
#include "dataset/parts.h"
#include "pipeline/plan/plan.h"

namespace scanmill {

// The shards of the plan that a process makes. With Listed and Any, other processes may work in the same folder, also
// from other machines: the process waits for shards that another one is making, and leaves existing shards as they are.
struct ShardChoice {
  enum class Kind {
    All,     // all shards, without other processes; the dataset is complete at the end
    Listed,  // the shards in `listed`; mergeDataset() completes the dataset
    Any,     // shards that no other process makes; the last process completes the dataset
  };
  Kind kind = Kind::All;
  std::vector<std::uint64_t> listed;  // numbers of shards, sorted
};

struct GenerateOptions {
  std::filesystem::path folder;
  std::filesystem::path keepHits;    // folder of a recording, or empty
  std::filesystem::path keepPasses;  // folder for passes, or empty; only for methods that render passes
  bool overwrite = false;            // replaces an existing dataset and existing recordings
  bool resume = false;               // continues an unfinished dataset; impossible with recordings
  ShardChoice shards;                // the shards that this process makes
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;  // set by a signal handler: generate() then throws Error
};

struct GenerateSummary {
  Manifest manifest;            // the manifest of the complete dataset; without shards and samples if `whole` is false
  bool whole = false;           // the dataset is complete, by this process or by another one that shares the folder
  std::size_t shards = 0;       // shards that this process has made
  std::size_t samplesMade = 0;  // samples in these shards
  std::size_t samples = 0;      // samples in all shards that it has made or found; beams, points and bytes are of these
  double seconds = 0;
  std::uint64_t beams = 0;
  std::uint64_t points = 0;
  std::uint64_t bytes = 0;
  std::map<std::uint16_t, std::uint64_t> pointsPerClass;
  StageSeconds stages;                // processor time of "trace", "effects", "encode", "write", ...
  std::size_t resumedShards = 0;      // shards that were complete already, or were made by others meanwhile
  std::vector<std::string> warnings;  // see pipeline/checks/warnings.h
};

// Returns the manifest of a plan's dataset if the folder holds the complete dataset, else nothing. Throws InputError if
// shards of it are missing or have the wrong size.
[[nodiscard]] std::optional<Manifest> wholeDatasetOf(const DatasetPlan& plan, const std::filesystem::path& folder);

// Makes the dataset of a plan, or some shards of it. Throws InputError for an unusable scene or folder, Error if the
// work fails. A folder without a manifest does not count as a dataset; an unfinished one can be resumed, which gives
// the same bytes (see dataset_folder.h).
GenerateSummary generate(const Plan& plan, const GenerateOptions& options);

}  // namespace scanmill
