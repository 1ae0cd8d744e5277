#pragma once

// Counts the contents of one scan. All counts are integers, so that sums do not depend on the order of addition.

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "base/vec.h"
#include "dataset/scan_store.h"
#include "scan/scan.h"

namespace scanmill {

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

// Returns the key under which an intensity is counted: the upper 16 bits of its float32 value; 0 if it is not positive.
// Integers up to 255 have different keys; other intensities are distinguished to within 1/128 of their value.
std::uint16_t intensityKey(float intensity);
float intensityOfKey(std::uint16_t key);  // returns the smallest intensity with this key

struct InstanceCounts {
  std::uint32_t id = 0;
  std::map<std::uint16_t, std::uint64_t> pointsOfClass{};
};

struct ScanCounts {
  std::uint64_t points = 0;  // number of finite points
  // Points per bin of range for each class; without labels, all points have the class 0.
  std::map<std::uint16_t, std::vector<std::uint64_t>> rangesOfClass;
  std::map<std::uint16_t, std::uint64_t> intensities;  // number of points by intensityKey()
  std::vector<InstanceCounts> instances;               // sorted by id; without the id 0
  std::map<std::uint16_t, std::uint64_t> withoutId;    // number of points without an instance id, by class
};

ScanCounts countScan(const Scan& scan, const RangeSteps& steps);

// Bins for views by visibility, as in nuScenes. A view is one object seen by one sensor in one sample. The first bin is
// for views without points.
inline constexpr std::array<const char*, 5> kVisibilitySteps{"no point", "to 40 %", "to 60 %", "to 80 %", "to 100 %"};
using VisibilityCounts = std::array<std::uint64_t, kVisibilitySteps.size()>;

// Upper ends of the bins of distance from the sensor to the centre of the object's box (m). A last bin without upper
// end follows.
inline constexpr std::array<double, 6> kDistanceSteps{10, 20, 30, 50, 80, 120};

struct ObjectCounts {
  std::uint64_t samples = 0;  // number of samples that were read
  std::map<std::uint16_t, VisibilityCounts> ofClass;
  std::array<VisibilityCounts, kDistanceSteps.size() + 1> ofDistance{};
};

// Reads the object lists of samples. `samples`: indices in Manifest::samples, ascending. Adds a line to `faults` for
// each list that cannot be read.
ObjectCounts countObjects(const ScanStore& store, const std::vector<std::size_t>& samples,
                          std::vector<std::string>& faults);

}  // namespace scanmill
