#pragma once

// Reads chosen scans of a dataset, whatever state its shards are in.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "scan/scan.h"
#include "study/dataset/scan_choice.h"

namespace scanmill {

// What is wrong with each shard's file, as an index into Manifest::shards; empty: nothing. Its size and, if `hashed`,
// its SHA-256 are compared with the manifest's.
std::vector<std::string> shardFaults(const std::filesystem::path& folder, const Manifest& manifest, bool hashed);

struct ScanReading {
  // Called for the k-th place, on several threads at once; for each place at most once.
  std::function<void(std::size_t k, Scan&& scan)> take;
  std::function<void(std::uint64_t scans, std::uint64_t points)> advance;  // now and then; may be empty
  const std::atomic<bool>* stop = nullptr;                                 // ends the reading with an Error
};

// `places` ascend. A scan in several formats is read from the most exact one that decodes. Gives what could not be
// read, one line each with the shard: scans that are not in it or that do not decode, or a shard that is no tar.
std::vector<std::string> readScans(const std::filesystem::path& folder, const Manifest& manifest,
                                   const std::vector<ScanPlace>& places, const ScanReading& reading);

}  // namespace scanmill
