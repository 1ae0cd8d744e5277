#pragma once

// The whole way: shots -> hits -> effects -> scans -> bytes -> shards -> manifest.

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

// Which shards of the plan a process makes. Listed and Any work together with other processes that share the folder, be
// it on other machines: what another one makes is waited for, what is there is left as it is.
struct ShardChoice {
  enum class Kind {
    All,     // alone; the dataset is whole at the end
    Listed,  // those listed; mergeDataset() ends the dataset
    Any,     // whatever nobody else makes; the last process ends the dataset
  };
  Kind kind = Kind::All;
  std::vector<std::uint64_t> listed;  // numbers of shards, sorted
};

struct GenerateOptions {
  std::filesystem::path folder;
  std::filesystem::path keepHits;    // folder of a recording, or empty
  std::filesystem::path keepPasses;  // likewise; methods that draw passes only
  bool overwrite = false;            // the dataset, and recordings
  bool resume = false;               // goes on with an unfinished dataset; not with recordings
  ShardChoice shards;                // which are made here
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;  // set by a signal handler: generate() then throws Error
};

struct GenerateSummary {
  Manifest manifest;            // of the whole dataset; without shards and samples where `whole` is false
  bool whole = false;           // the dataset is ended: by this process, or by another one that shares the folder
  std::size_t shards = 0;       // that this process has made
  std::size_t samplesMade = 0;  // in them
  std::size_t samples = 0;      // that are counted in what follows
  double seconds = 0;
  std::uint64_t beams = 0;
  std::uint64_t points = 0;
  std::uint64_t bytes = 0;
  std::map<std::uint16_t, std::uint64_t> pointsPerClass;
  StageSeconds stages;                // of processor time ("trace", "effects", "encode", "write", ...)
  std::size_t resumedShards = 0;      // that were whole already, or were made by others meanwhile
  std::vector<std::string> warnings;  // what is legal, but seldom meant: see pipeline/checks/warnings.h
};

// The manifest of the whole dataset of a plan, where the folder holds it. Throws InputError where shards of it are
// missing.
std::optional<Manifest> wholeDatasetOf(const DatasetPlan& plan, const std::filesystem::path& folder);

// Throws InputError for an unusable scene or folder, Error where the work fails. Without a manifest nothing in the
// folder counts as a dataset; what is unfinished can be resumed, and gives the same bytes (see dataset_folder.h).
GenerateSummary generate(const Plan& plan, const GenerateOptions& options);

}  // namespace scanmill
