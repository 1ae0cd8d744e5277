#pragma once

// Re-hashes, decodes and compares a dataset with its manifest.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace scanmill {

struct Verification {
  std::uint64_t shards = 0;
  std::uint64_t samples = 0;
  std::uint64_t scans = 0;
  std::uint64_t points = 0;
  std::vector<std::string> problems;  // one line each, with shard and member; empty: the dataset is sound
};

// Never throws for what is wrong with the data (a missing shard, a wrong hash, a member that does not decode, counts
// that disagree, a class id unknown to the ontology, members out of order, files nobody listed): it goes on and lists
// all. An unreadable manifest is an InputError. progress(done, total) counts shards.
Verification verifyDataset(const std::filesystem::path& folder,
                           const std::function<void(std::uint64_t, std::uint64_t)>& progress = {});

}  // namespace scanmill
