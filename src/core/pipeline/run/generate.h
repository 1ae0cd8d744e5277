#pragma once

// Makes the dataset of a plan: shots -> hits -> effects -> scans -> bytes -> shards -> manifest.
//
//   const GenerateSummary made = generate(plan, {.folder = "out/street", .quiet = true});
//   std::printf("%zu samples, %llu points\n", made.samples, static_cast<unsigned long long>(made.points));

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/stage_clock.h"
#include "dataset/dataset_folder.h"
#include "dataset/manifest.h"
#include "pipeline/plan/plan.h"

namespace scanmill {

// The shards of the plan that a process makes. With Listed and Any, other processes, also on other machines, may work
// in the same folder at the same time. The process then skips complete shards, and waits for shards that another
// process is making.
struct ShardChoice {
  enum class Kind {
    All,     // all shards; no other process may use the folder; the dataset is complete at the end
    Listed,  // the shards in `listed`; mergeDataset() later completes the dataset
    Any,     // all shards that no other process makes; the last process completes the dataset
  };
  Kind kind = Kind::All;
  std::vector<std::uint64_t> listed;  // indices of shards in shardJobs(), sorted; only for Listed
};

struct GenerateOptions {
  std::filesystem::path folder;
  std::filesystem::path keepHits{};  // folder in which the hits are recorded; empty: no recording
  bool overwrite = false;            // replaces an existing dataset and an existing recording
  bool resume = false;               // continues an unfinished dataset; cannot be combined with recordings
  bool anyFiles = false;             // keeps complete shards although files that they were made from have changed
  ShardChoice shards{};              // the shards that this process makes
  bool quiet = false;
  // Called when samples are made, or are found complete: their number, and that of all samples of this process. Calls
  // do not overlap. Empty: nothing is called.
  std::function<void(std::uint64_t done, std::uint64_t all)> progress{};
  // A flag that a signal handler sets; once the flag is true, generate() throws Error. Null: there is no flag.
  const std::atomic<bool>* stop = nullptr;

  FolderUse use() const {
    if (shards.kind != ShardChoice::Kind::All) return FolderUse::Share;
    return resume ? FolderUse::Resume : overwrite ? FolderUse::Replace : FolderUse::New;
  }
};

struct GenerateSummary {
  Manifest manifest;            // the dataset's manifest; without shards and samples if `complete` is false
  bool complete = false;        // the dataset is complete, whichever process completed it
  std::size_t shards = 0;       // number of shards that this process has made
  std::size_t samplesMade = 0;  // number of samples in the shards that this process has made
  // Samples in the shards that this process made or found. `beams`, `points`, `bytes`: totals of these shards.
  std::size_t samples = 0;
  double seconds = 0;
  std::uint64_t beams = 0;
  std::uint64_t points = 0;
  std::uint64_t bytes = 0;
  std::map<std::uint16_t, std::uint64_t> pointsPerClass;
  StageSeconds stages;            // time (s) of "trace", "effects", "encode", "write" and other stages: see StageTimer
  double processorSeconds = 0;    // processor time of the process, from beginning to end
  std::size_t resumedShards = 0;  // number of shards that were complete before, or that other processes made meanwhile
  std::vector<std::string> warnings;  // lines about the scenes and sequences, see pipeline/checks/warnings.h
};

// Returns the manifest of a plan's dataset if the folder has the complete dataset, and tidies the folder; otherwise
// returns nothing. Throws InputError if a shard is missing or has the wrong size.
[[nodiscard]] std::optional<Manifest> wholeDatasetOf(const DatasetPlan& plan, const std::filesystem::path& folder);

// Makes the dataset of a plan, or some of its shards. Throws InputError for an unusable scene or folder, and Error if
// the work fails. An unfinished dataset has no manifest; it can be resumed, which gives the same bytes as an
// uninterrupted run (see dataset_folder.h).
GenerateSummary generate(const Plan& plan, const GenerateOptions& options);

}  // namespace scanmill
