#pragma once

// Reads selected scans of a dataset, even if some shards are missing or damaged.

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

// Returns one text per shard of the manifest: the shard's fault, or an empty text if the shard is sound. Compares the
// file's size with the manifest, and its SHA-256 too if `hashed` is true.
std::vector<std::string> shardFaults(const std::filesystem::path& folder, const Manifest& manifest, bool hashed);

struct ScanReading {
  // Receives the scan at index k of `places`. Called from several threads at a time, at most once for each index.
  std::function<void(std::size_t k, Scan&& scan)> take;
  // Called repeatedly with the numbers of scans and points that were read since the previous call; may be empty.
  std::function<void(std::uint64_t scans, std::uint64_t points)> advance;
  const std::atomic<bool>* stop = nullptr;  // if it becomes true, readScans() throws Error; may be null
};

// Reads the scans at `places`. If a scan is stored in several formats, uses the most exact format that can be decoded.
// Returns the faults, one line each with the shard's name: missing scans, scans that cannot be decoded, and shards that
// are damaged or not tar files. Missing shards are not among them; shardFaults() reports these.
std::vector<std::string> readScans(const std::filesystem::path& folder, const Manifest& manifest,
                                   const std::vector<ScanPlace>& places, const ScanReading& reading);

}  // namespace scanmill
