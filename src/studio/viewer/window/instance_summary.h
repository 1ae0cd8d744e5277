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
  // The smallest upright box that holds the points: its longer and shorter side and its height (m), and its place in
  // the scan that was turned upright, the longer side along x and the origin in the middle.
  Vec3d size;
  Affine levelFromBox;
};

// `levelFromScan` turns the scan upright.
InstanceSummary summarizeInstance(const Scan& scan, std::uint32_t instance, const Affine& levelFromScan);
// Of all instances but 0, by their ids.
std::vector<InstanceSummary> summarizeInstances(const Scan& scan, const Affine& levelFromScan);

}  // namespace scanmill
