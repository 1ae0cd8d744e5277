#pragma once

// What a scan holds of one instance.

#include <cstdint>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "scan/scan.h"

namespace scanmill {

struct InstanceSummary {
  std::uint32_t id = 0;
  std::vector<std::uint32_t> points;                             // of the scan, ascending; finite ones
  std::vector<std::pair<std::uint16_t, std::uint64_t>> classes;  // id and points, the most first; empty without labels
  Vec3d size;  // m: longer and shorter side of the smallest upright box that holds the points, and its height
};

// `levelFromScan` turns the scan upright.
InstanceSummary summarizeInstance(const Scan& scan, std::uint32_t instance, const Affine& levelFromScan);

}  // namespace scanmill
