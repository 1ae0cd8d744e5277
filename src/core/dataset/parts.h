#pragma once

// A dataset in parts: its plan, the records of its complete shards, and how these are joined.
//
// Any number of processes write parts, in any order. A part states its plan and which of the plan's samples it holds,
// so that parts of another plan, missing samples and duplicates are found.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dataset/manifest.h"

namespace scanmill {

struct DatasetPlan {
  std::string hash;  // a text without line breaks, different for plans of different datasets
  std::uint64_t samples = 0;
  std::vector<std::pair<std::string, std::uint64_t>> shardsOfSplit;  // in the order of the shards
  std::optional<MethodRecord> chosen = {};                           // set if the pipeline says `method: auto`

  bool operator==(const DatasetPlan&) const = default;
  // Returns the names of all shards, see shardName().
  std::vector<std::string> shards() const;
};

struct DatasetPart {
  std::string plan;                    // hash of its plan
  std::vector<std::uint64_t> numbers;  // indices of its samples among all samples of the plan
  Manifest manifest;                   // with only this shard and its samples
};

std::string toJson(const DatasetPlan& plan);
std::string toJson(const DatasetPart& part);
// Throw an InputError that names `file`, the place in it, and what is wrong there.
DatasetPlan parsePlan(const std::string& text, const std::string& file);
DatasetPart parsePart(const std::string& text, const std::string& file);

// Returns the manifest of the complete dataset, from all parts in the order of the plan's shards. Throws Error if a
// sample is missing or occurs twice.
Manifest joinParts(const DatasetPlan& plan, std::vector<DatasetPart> parts);

}  // namespace scanmill
