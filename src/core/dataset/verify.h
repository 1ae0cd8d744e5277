#pragma once

// Checks a complete dataset: hashes its shards again, decodes its scans and compares everything with the manifest.
//
//   for (const std::string& fault : verifyDataset("out/quickstart").problems) std::puts(fault.c_str());

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "scan/scan.h"

namespace scanmill {

struct Verification {
  std::uint64_t shards = 0;
  std::uint64_t samples = 0;
  std::uint64_t scans = 0;
  std::uint64_t points = 0;
  std::vector<std::uint64_t> damaged{};  // numbers of the shards with a fault in the shard or its samples' file
  std::vector<std::string> problems{};   // one line each, with shard and member; empty: the dataset is sound
};

// Lists all faults of the data, not only the first. Faults are a missing shard, a wrong hash, a member that cannot be
// decoded, counts that differ, a class id that the ontology does not have, members out of order, a file that describes
// samples and is missing or damaged, and files that the manifest does not list. If the file that describes a shard's
// samples is damaged, only the hash and size of the shard are checked. Throws an InputError only if the manifest cannot
// be read. Calls progress(number of checked shards, number of all shards) after each shard.
[[nodiscard]] Verification verifyDataset(const std::filesystem::path& folder,
                                         const std::function<void(std::uint64_t, std::uint64_t)>& progress = {});

// Returns one text per shard of the manifest: the shard's fault, or an empty text if the shard is sound. Compares the
// file's size and, if `hashed` is true, the file's SHA-256 with the manifest.
std::vector<std::string> shardFaults(const std::filesystem::path& folder, const Manifest& manifest, bool hashed);

// Returns one line for each fault; none for a sound scan. `record`: the scan's record in the manifest, which must list
// the record's sensor. `maxError`: largest error of a position in the scan's format (m).
[[nodiscard]] std::vector<std::string> checkScan(const Scan& scan, const ScanRecord& record, const Manifest& manifest,
                                                 double maxError);

}  // namespace scanmill
