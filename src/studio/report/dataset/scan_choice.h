#pragma once

// Chooses which scans of a dataset a report reads, and which scans it shows.

#include <compare>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "dataset/manifest.h"

namespace scanmill {

struct ScanPlace {
  std::size_t sample = 0;  // index in Manifest::samples
  std::size_t scan = 0;    // index in the sample's scans

  auto operator<=>(const ScanPlace&) const = default;
};

// Returns all scans; if there are more than `most`, returns `most` scans, evenly distributed over the dataset. Sorted.
std::vector<ScanPlace> spreadScans(const Manifest& manifest, std::size_t most);

// Returns one scan from each of at most `count` random samples. Splits and sensors alternate, so that a few samples
// include all of them. Skips scans without points and scans in damaged shards. `sound`: for each shard, whether it is
// undamaged. The same seed chooses the same scans.
std::vector<ScanPlace> randomScans(const Manifest& manifest, const std::vector<bool>& sound, std::size_t count,
                                   std::uint64_t seed);

}  // namespace scanmill
