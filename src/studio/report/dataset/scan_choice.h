#pragma once

// Chooses which of a dataset's scans a report reads, and which it shows.

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

// All scans, or `most` of them spread evenly over the dataset, ascending.
std::vector<ScanPlace> spreadScans(const Manifest& manifest, std::size_t most);

// One scan from each of `count` random samples. Splits take turns, and so do sensors, so that a few samples show all of
// them. Empty scans, and those in shards that are not `sound`, are passed over. The same seed chooses the same scans.
std::vector<ScanPlace> randomScans(const Manifest& manifest, const std::vector<bool>& sound, std::size_t count,
                                   std::uint64_t seed);

}  // namespace scanmill
