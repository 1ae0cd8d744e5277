#pragma once

// Chooses the points of a scan that a page shows.

#include <cstddef>
#include <vector>

#include "scan/scan.h"

namespace scanmill {

// Returns the indices of the finite points to show, ascending: all points, or `most` of them. Instances and classes
// with few points are kept complete, the smallest first, as long as they take at most half of `most`. The other points
// are thinned evenly along the scan, such that the fraction kept is proportional to the square of the distance. Since
// the density of LiDAR points on a surface decreases with this square, near surfaces lose many points and far surfaces
// few.
std::vector<std::size_t> pointsToView(const Scan& scan, std::size_t most);

}  // namespace scanmill
