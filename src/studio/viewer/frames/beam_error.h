#pragma once

// Measures how far noise has moved the points of a scan.

#include <string>
#include <vector>

#include "scan/scan.h"
#include "sensors/beams.h"

namespace scanmill {

// Returns the distance (m) of each point of the scan from the point of the same beam and return in its noise-free
// reference; NaN if the beam has no return in the reference, and for false positives, which no surface caused. Points
// are joined by ring, column and return number, which follow from the order of the points in an organised scan.
//
// The return number counts the beam's returns in this scan, the nearest first. Hence it identifies the same return in
// both scans only if the beam has equally many returns in both. If drop-out or false positives have changed the count,
// or one of the scans does not number its returns, each point is joined to the nearest of the beam's returns in the
// reference. This is the same surface as long as the noise is less than half the distance between two surfaces.
//
// Empty if the scans cannot be joined; then `why` tells the user what the scans lack.
std::vector<float> referenceErrors(const Scan& scan, const Scan& reference, std::string& why);

// Returns the difference (m) of each point's range from `range_true`; NaN if a point has no range. Ranges count from
// the beam's origin; without a beam table, from the sensor's origin. Empty if the scan lacks the column `range_true`.
std::vector<float> rangeErrors(const Scan& scan, const BeamTable* beams);

}  // namespace scanmill
