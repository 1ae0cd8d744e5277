#pragma once

// Chooses which points of a scan a page shows.

#include <cstddef>
#include <vector>

#include "scan/scan.h"

namespace scanmill {

// The indices of the finite points that are shown, ascending: all, or `most` of them. Instances and classes of few
// points stay whole, the smallest first, as long as they take up to half of `most`. Of the other points a share is kept
// that grows with the square of the distance, evenly along the scan: a LiDAR's points on a surface become rarer by that
// square, so that near surfaces lose what they have too many of and far surfaces keep what they have.
std::vector<std::size_t> pointsToView(const Scan& scan, std::size_t most);

}  // namespace scanmill
