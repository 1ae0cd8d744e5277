#pragma once

// Reads selected scans of a dataset, even if some shards are missing or damaged.

#include <atomic>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/error.h"
#include "dataset/manifest.h"
#include "dataset/scan_store.h"
#include "scan/scan.h"

namespace scanmill {

struct ScanIndex {
  std::size_t sample = 0;  // index in Manifest::samples
  std::size_t scan = 0;    // index in the sample's scans

  auto operator<=>(const ScanIndex&) const = default;
};

// Returns all scans; if there are more than `most`, returns `most` scans, evenly distributed over the dataset. Sorted.
std::vector<ScanIndex> spreadScans(const Manifest& manifest, std::size_t most);

// Returns one scan from each of at most `count` random samples. Splits and sensors alternate, so that a few samples
// include all of them. Skips scans without points and scans in damaged shards. `sound`: for each shard, whether it is
// undamaged. The same seed chooses the same scans.
std::vector<ScanIndex> randomScans(const Manifest& manifest, const std::vector<bool>& sound, std::size_t count,
                                   std::uint64_t seed);

// Returns one text per shard of the manifest: the shard's fault, or an empty text if the shard is sound. Compares the
// file's size with the manifest, and its SHA-256 too if `hashed` is true.
std::vector<std::string> shardFaults(const std::filesystem::path& folder, const Manifest& manifest, bool hashed);

// Returns why something of a sample cannot be read, with paths from the dataset's folder. If the sample's shard is
// damaged, this is the damage, so that all that is lost by it has the same text.
std::string readingFault(const ScanStore& store, std::size_t sample, const InputError& error);

struct ScanReading {
  // Receives the scan of places[k] of readScans(). Called from several threads at a time, at most once for each index.
  std::function<void(std::size_t k, Scan&& scan)> take;
  // Called repeatedly with the numbers of scans and points that were read since the previous call; may be empty.
  std::function<void(std::uint64_t scans, std::uint64_t points)> advance;
  const std::atomic<bool>* stop = nullptr;  // if it becomes true, readScans() throws Error; may be null
};

// Reads the scans at `places` of a dataset. If a scan is stored in several formats, uses the most exact format that can
// be decoded. Returns the faults, one line for each scan that cannot be read, or one line for all scans of a shard that
// is truncated or not a tar file. Scans of missing shards are not among them; shardFaults() reports these.
std::vector<std::string> readScans(const ScanStore& store, const std::vector<ScanIndex>& places,
                                   const ScanReading& reading);

}  // namespace scanmill
