#pragma once

// Which points of a scan a page shows.

#include <cstddef>
#include <vector>

#include "scan/scan.h"

namespace scanmill {

// Indices of the finite points, ascending: all, or `most` of them. Instances and classes of few points stay whole, the
// smallest first and for up to half of `most`. Of the others near ones are thinned, in proportion to the square of
// their distance, evenly along the scan: a LiDAR's points on a surface become rarer by that square, so that near
// surfaces lose what they have too much of and far ones keep what they have.
std::vector<std::size_t> pointsToView(const Scan& scan, std::size_t most);

}  // namespace scanmill
