#pragma once

// Counts how much sensors see of the objects that samples list, by class and by distance.

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "dataset/manifest.h"

namespace scanmill {

// Bins of views. A view is one object seen by one sensor in one sample; views with points are binned by visibility, in
// the steps of nuScenes.
inline constexpr std::array<const char*, 5> kVisibilitySteps{"no point", "to 40 %", "to 60 %", "to 80 %", "to 100 %"};
using VisibilityCounts = std::array<std::uint64_t, kVisibilitySteps.size()>;

// Upper ends of the steps of distance (m) from the sensor to the middle of the box; one more step, the last, is open.
inline constexpr std::array<double, 6> kDistanceSteps{10, 20, 30, 50, 80, 120};

struct ObjectCounts {
  std::uint64_t samples = 0;  // samples read
  std::map<std::uint16_t, VisibilityCounts> ofClass;
  std::array<VisibilityCounts, kDistanceSteps.size() + 1> ofDistance{};
};

// Reads the object lists of these samples of a dataset (indices into Manifest::samples, ascending). Each list that
// cannot be read adds a line to `faults`.
ObjectCounts countObjects(const std::filesystem::path& folder, const Manifest& manifest,
                          const std::vector<std::size_t>& samples, std::vector<std::string>& faults);

}  // namespace scanmill
