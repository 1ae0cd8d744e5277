#pragma once

// Counts how well sensors see the objects that samples list, by class and by distance.

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "dataset/manifest.h"

namespace scanmill {

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
ObjectCounts countObjects(const std::filesystem::path& folder, const Manifest& manifest,
                          const std::vector<std::size_t>& samples, std::vector<std::string>& faults);

}  // namespace scanmill
