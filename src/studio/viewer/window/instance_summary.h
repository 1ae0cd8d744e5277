#pragma once

// Summarises the points of an instance in a scan: their number, classes and box.

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/vec.h"
#include "scan/scan.h"

namespace scanmill {

struct InstanceSummary {
  std::uint32_t id = 0;
  std::vector<std::uint32_t> points;  // indices of the instance's finite points, ascending
  // Pairs of class id and number of points, the most frequent class first; empty if the scan has no labels.
  std::vector<std::pair<std::uint16_t, std::uint64_t>> classes;
  // The smallest upright box that contains the points. `size`: longer side, shorter side and height (m).
  // `levelFromBox`: transform from the box's frame, with x along the longer side and the origin at the box's centre, to
  // the level frame.
  Vec3d size;
  Affine levelFromBox;
};

// Summarises one instance. `places`: positions of the scan's points (m). `levelFromPlaces`: transform from their frame
// to a frame whose z axis is vertical.
InstanceSummary summarizeInstance(const Scan& scan, std::span<const Vec3f> places, std::uint32_t instance,
                                  const Affine& levelFromPlaces);
// Summarises all instances except 0, in the order of their ids.
std::vector<InstanceSummary> summarizeInstances(const Scan& scan, std::span<const Vec3f> places,
                                                const Affine& levelFromPlaces);

}  // namespace scanmill
