#pragma once

// Reads chosen scans of a dataset, even if some of its shards are missing or damaged.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "report/dataset/scan_choice.h"
#include "scan/scan.h"

namespace scanmill {

// Returns the fault of each shard of the manifest; empty if the shard is sound. Compares the size of the shard's file
// and, if `hashed`, its SHA-256 with the manifest.
std::vector<std::string> shardFaults(const std::filesystem::path& folder, const Manifest& manifest, bool hashed);

struct ScanReading {
  // Takes the scan at index k of `places`. It is called on several threads at once, and at most once for each index.
  std::function<void(std::size_t k, Scan&& scan)> take;
  // Called now and then with the numbers of scans and points read since the last call; may be empty.
  std::function<void(std::uint64_t scans, std::uint64_t points)> advance;
  const std::atomic<bool>* stop = nullptr;  // true: reading ends with an Error
};

// Reads the scans at `places`. A scan stored in several formats is read from the most exact format that can be decoded.
// Returns the faults, one line each with the shard: scans that are missing or cannot be decoded, and shards that are
// not tar files.
std::vector<std::string> readScans(const std::filesystem::path& folder, const Manifest& manifest,
                                   const std::vector<ScanPlace>& places, const ScanReading& reading);

}  // namespace scanmill
