#pragma once

// Reads chosen scans of a dataset, whatever state its shards are in.

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

// What is wrong with the file of each shard of the manifest; empty where it is sound. Its size and, if `hashed`, its
// SHA-256 are compared with the manifest's.
std::vector<std::string> shardFaults(const std::filesystem::path& folder, const Manifest& manifest, bool hashed);

struct ScanReading {
  // Takes the scan of the k-th place. It is called on several threads at once, and for each place at most once.
  std::function<void(std::size_t k, Scan&& scan)> take;
  // Is called now and then with the numbers of scans and points that were read since its last call; may be empty.
  std::function<void(std::uint64_t scans, std::uint64_t points)> advance;
  const std::atomic<bool>* stop = nullptr;  // true ends the reading with an Error
};

// Reads the scans at `places`. A scan in several formats is read from the most exact one that can be
// decoded. The result says what could not be read, one line each with the shard: scans that are not in it or that
// cannot be decoded, or a shard that is no tar.
std::vector<std::string> readScans(const std::filesystem::path& folder, const Manifest& manifest,
                                   const std::vector<ScanPlace>& places, const ScanReading& reading);

}  // namespace scanmill
