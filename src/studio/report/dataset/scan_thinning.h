#pragma once

// Chooses the points of a scan that a page shows.

#include <cstddef>
#include <vector>

#include "scan/scan.h"

namespace scanmill {

// Returns the indices of the finite points to show, ascending: all, or `most` of them. Instances and classes with few
// points are kept complete, the smallest first, as long as they take up to half of `most`. Of the other points a share
// is kept that grows with the square of the distance, evenly along the scan: the density of a LiDAR's points on a
// surface falls with that square, so that near surfaces lose surplus points and far surfaces keep theirs.
std::vector<std::size_t> pointsToView(const Scan& scan, std::size_t most);

}  // namespace scanmill
