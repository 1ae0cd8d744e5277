#pragma once

// Checks a whole dataset: hashes its shards again, decodes its scans and compares all with the manifest.

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
  std::uint64_t damaged = 0;          // shards that are not as the manifest says
  std::vector<std::string> problems;  // one line each, with shard and member; empty: the dataset is sound
};

// Lists all that is wrong with the data and goes on after each fault: a missing shard, a wrong hash, a member that
// cannot be decoded, counts that differ, a class id that the ontology does not have, members out of order, files that
// nobody lists. Throws an InputError only where the manifest cannot be read. progress(done, total) counts shards; it is
// called after each.
Verification verifyDataset(const std::filesystem::path& folder,
                           const std::function<void(std::uint64_t, std::uint64_t)>& progress = {});

}  // namespace scanmill
