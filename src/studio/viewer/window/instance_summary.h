#pragma once

// Summarises the points of an instance in a scan: their number, classes and box.

#include <cstdint>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "scan/scan.h"

namespace scanmill {

struct InstanceSummary {
  std::uint32_t id = 0;
  std::vector<std::uint32_t> points;                             // indices of its finite points, ascending
  std::vector<std::pair<std::uint16_t, std::uint64_t>> classes;  // id and number of points, the largest number first;
                                                                 // empty without labels
  // The smallest upright box that holds the points: its longer and shorter side and its height (m), and its pose in the
  // scan after levelFromScan; the longer side is along x, the origin is the box's centre.
  Vec3d size;
  Affine levelFromBox;
};

// Summarises one instance. `levelFromScan` turns the scan upright.
InstanceSummary summarizeInstance(const Scan& scan, std::uint32_t instance, const Affine& levelFromScan);
// Summarises all instances except 0, in the order of their ids.
std::vector<InstanceSummary> summarizeInstances(const Scan& scan, const Affine& levelFromScan);

}  // namespace scanmill
