#pragma once

// Chooses the scans of a dataset that a report reads, and the scans that it shows.

#include <compare>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "dataset/manifest.h"

namespace scanmill {

struct ScanPlace {
  std::size_t sample = 0;  // index into Manifest::samples
  std::size_t scan = 0;    // index into the sample's scans

  auto operator<=>(const ScanPlace&) const = default;
};

// Returns all scans, or `most` of them spread evenly over the dataset, ascending.
std::vector<ScanPlace> spreadScans(const Manifest& manifest, std::size_t most);

// Returns one scan from each of `count` random samples. Splits and sensors take turns, so that a few samples show all
// of them. Empty scans, and scans in shards that are not `sound`, are skipped. The same seed chooses the same scans.
std::vector<ScanPlace> randomScans(const Manifest& manifest, const std::vector<bool>& sound, std::size_t count,
                                   std::uint64_t seed);

}  // namespace scanmill
