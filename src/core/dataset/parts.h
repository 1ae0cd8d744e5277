#pragma once

// A dataset in parts: what is planned of it, what is known of each shard that is whole, and how these are joined.
//
// Parts are made by any number of processes, in any order. A part says which plan it is of and which of the plan's
// samples it holds, so that parts of something else, gaps and doubles are found.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dataset/manifest.h"

namespace scanmill {

struct DatasetPlan {
  std::string hash;  // a text without line breaks that differs where what is made differs
  std::uint64_t samples = 0;
  std::vector<std::pair<std::string, std::uint64_t>> shardsOfSplit;  // in the order of the shards
  std::optional<MethodRecord> chosen = {};                           // where the pipeline left the choice of the method

  bool operator==(const DatasetPlan&) const = default;
  // The names of all shards, see shardName().
  std::vector<std::string> shards() const;
};

struct DatasetPart {
  std::string plan;                    // its hash
  std::vector<std::uint64_t> numbers;  // of its samples among all of the plan, from 0
  Manifest manifest;                   // with this shard and its samples alone
};

std::string toJson(const DatasetPlan& plan);
std::string toJson(const DatasetPart& part);
// Throw an InputError that names `file`, the place in it, and what is wrong there.
DatasetPlan parsePlan(const std::string& text, const std::string& file);
DatasetPart parsePart(const std::string& text, const std::string& file);

// The manifest of the whole, from all parts in the order of the plan's shards. Throws Error for samples that are
// missing or there twice.
Manifest joinParts(const DatasetPlan& plan, std::vector<DatasetPart> parts);

}  // namespace scanmill
