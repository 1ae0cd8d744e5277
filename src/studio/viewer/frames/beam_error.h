#pragma once

// Measures how far the points of a scan lie from where they would be without noise.

#include <string>
#include <vector>

#include "scan/scan.h"
#include "sensors/beams.h"

namespace scanmill {

// The distance (m) of each point of the scan from the point of the same beam and return in its noise-free reference;
// NaN where the beam has none there, and of false positives, which no surface made. Points are joined by ring, column
// and number of the return, which an organised scan knows by its order.
//
// The number is that of a beam's returns as they are in the scan, the nearest first. Hence it names the same return in
// both scans only where the beam has as many in both. Where drop-out or false positives have changed their count, or
// one of the scans does not number its returns, each point is joined to the nearest of the beam's returns in the
// reference: the same surface, as long as the noise is less than half of what lies between two surfaces.
//
// Empty where the scans cannot be joined; then `why` says to the user what they lack.
std::vector<float> referenceErrors(const Scan& scan, const Scan& reference, std::string& why);

// The difference (m) of each point's range from `range_true`; NaN where a point has no range. Ranges count from where
// the beam starts; without a beam table, from the sensor's origin. Empty where the scan lacks the column `range_true`.
std::vector<float> rangeErrors(const Scan& scan, const BeamTable* beams);

}  // namespace scanmill
