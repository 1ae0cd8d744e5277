#pragma once

// A dataset in parts: its plan, the records of its complete shards, and the function that joins them.
//
// Any number of processes may write parts, in any order. A part names its plan and the samples that it contains, so
// that parts of another plan, missing samples and duplicates are detected.

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "dataset/manifest.h"

namespace scanmill {

struct DatasetPlan {
  std::string hash;  // a text without line breaks that differs between plans of different datasets
  std::uint64_t samples = 0;
  struct Split {
    std::string name;
    std::uint64_t shards = 0;  // number of shards
    bool operator==(const Split&) const = default;
  };
  std::vector<Split> splits;  // in the order of the shards

  bool operator==(const DatasetPlan&) const = default;
  // Returns the names of all shards, see shardName().
  std::vector<std::string> shards() const;
};

struct DatasetPart {
  std::string plan;                      // hash of the part's plan
  std::vector<std::uint64_t> numbers;    // indices of the part's samples among all samples of the plan
  Manifest manifest;                     // manifest with only this shard and its samples
  std::vector<std::string> placed = {};  // hash of what the caller placed in each sample; only of a DatasetWriter
};

std::string toJson(const DatasetPlan& plan);
std::string toJson(const DatasetPart& part);
// Parse the texts that toJson() writes. Throw an InputError that names `file`, the place in the text, and the problem.
DatasetPlan parsePlan(const std::string& text, const std::string& file);
DatasetPart parsePart(const std::string& text, const std::string& file);

// Returns the manifest of the complete dataset. `parts`: all parts, in the order of the plan's shards. Throws Error if
// a sample is missing, occurs twice or is not in the plan. Unless `anyFiles` is true, also throws Error if two parts
// were made from different contents of the same file.
[[nodiscard]] Manifest joinParts(const DatasetPlan& plan, std::vector<DatasetPart> parts, bool anyFiles = false);

// Joins the parts in a folder, writes the manifest, and returns it. If the dataset is already complete, only returns
// its manifest. Shards are checked by their records and sizes, but not read; verifyDataset() reads them. Throws
// InputError if shards are missing (with their numbers), if parts belong to another plan, or if a process is writing
// into the folder. Throws Error if a sample occurs twice or the disk fails.
Manifest mergeDataset(const std::filesystem::path& folder);

}  // namespace scanmill
