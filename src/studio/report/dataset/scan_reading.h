#pragma once

// Reads selected scans of a dataset, even if some shards are missing or damaged, and counts their contents. All counts
// are integers, so that sums do not depend on the order of addition.

#include <algorithm>
#include <array>
#include <atomic>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/vec.h"
#include "dataset/manifest.h"
#include "dataset/scan_store.h"
#include "scan/scan.h"

namespace scanmill {

struct ScanIndex {
  std::size_t sample = 0;  // index in Manifest::samples
  std::size_t scan = 0;    // index in the sample's scans

  auto operator<=>(const ScanIndex&) const = default;
};

// Returns all scans or, if there are more than `most`, `most` scans evenly distributed over the dataset, sorted.
std::vector<ScanIndex> spreadScans(const Manifest& manifest, std::size_t most);

// Returns one scan from each of at most `count` random samples. Splits and sensors alternate, so that a few samples
// include all splits and sensors. Skips scans without points and scans in damaged shards. `sound`: for each shard,
// whether it is undamaged. The same seed chooses the same scans.
std::vector<ScanIndex> randomScans(const Manifest& manifest, const std::vector<bool>& sound, std::size_t count,
                                   std::uint64_t seed);

// Returns why a part of a sample cannot be read, with paths relative to the dataset's folder. If the sample's shard is
// damaged, returns the damage instead, which is the same text for all samples of the shard.
std::string readingFault(const ScanStore& store, std::size_t sample, const InputError& error);

struct ScanReading {
  // Receives the scan of places[k] of readScans(). Called from several threads at a time, at most once for each index.
  std::function<void(std::size_t k, Scan&& scan)> take;
  // Called for each scan, with its number of points; may be empty.
  std::function<void(std::uint64_t points)> advance;
  const std::atomic<bool>* stop = nullptr;  // if it becomes true, readScans() throws Error; may be null
};

// Reads the scans at `places` of a dataset. If a scan is stored in several formats, uses the most exact format that can
// be decoded. Returns the faults: a line for each scan that cannot be read, or one line for all scans of a shard that
// is truncated or not a tar file. Ignores scans of missing shards, which shardFaults() in dataset/verify.h
// reports.
std::vector<std::string> readScans(const ScanStore& store, const std::vector<ScanIndex>& places,
                                   const ScanReading& reading);

// Bins of distance from the sensor. The last bin includes all larger distances.
struct RangeSteps {
  double step = 1;  // width of a bin (m)
  std::size_t count = 1;

  // Returns the index of the bin that contains a distance (m).
  std::size_t of(double distance) const {
    return static_cast<std::size_t>(std::min(distance / step, static_cast<double>(count - 1)));
  }
};

// Returns bins for ranges up to `farthest` (m): at most 120 bins of 0.1, 0.2, 0.5, 1, 2, 5, ... metres, and one bin for
// larger ranges.
RangeSteps rangeStepsFor(double farthest);

// Returns the key under which an intensity is counted: the upper 16 bits of the float32 value; 0 if the value is not
// positive. Integers up to 255 have different keys; other intensities are distinguished to within 1/128 of the value.
std::uint16_t intensityKey(float intensity);
float intensityOfKey(std::uint16_t key);  // returns the smallest intensity with this key

using ClassPoints = std::map<std::uint16_t, std::uint64_t>;  // number of points by class

struct ScanCounts {
  std::uint64_t points = 0;  // number of finite points
  // Points per bin of range for each class; without labels, all points have the class 0.
  std::map<std::uint16_t, std::vector<std::uint64_t>> rangesOfClass;
  std::map<std::uint16_t, std::uint64_t> intensities;  // number of points by intensityKey()
  std::map<std::uint32_t, ClassPoints> instances;      // the points of each instance id but 0
  ClassPoints withoutId;                               // the points without an instance id
};

ScanCounts countScan(const Scan& scan, const RangeSteps& steps);

// Bins for views by visibility, as in nuScenes. A view is one object seen by one sensor in one sample. The first bin is
// for views without points.
inline constexpr std::array<const char*, 5> kVisibilitySteps{"no point", "to 40 %", "to 60 %", "to 80 %", "to 100 %"};
using VisibilityCounts = std::array<std::uint64_t, kVisibilitySteps.size()>;

// Upper ends (m) of the bins of the distance from the sensor to the centre of the object's box. A last bin without
// upper end follows.
inline constexpr std::array<double, 6> kDistanceSteps{10, 20, 30, 50, 80, 120};

struct ObjectCounts {
  std::uint64_t samples = 0;  // number of samples that were read
  std::map<std::uint16_t, VisibilityCounts> ofClass;
  std::array<VisibilityCounts, kDistanceSteps.size() + 1> ofDistance{};
};

// Counts the objects in the object lists of samples. `samples`: indices in Manifest::samples, ascending. Adds a line to
// `faults` for each list that cannot be read.
ObjectCounts countObjects(const ScanStore& store, const std::vector<std::size_t>& samples,
                          std::vector<std::string>& faults);

}  // namespace scanmill
