#pragma once

// Measures how far the points of a scan lie from where they would be without noise.

#include <string>
#include <vector>

#include "scan/scan.h"
#include "sensors/beams.h"

namespace scanmill {

// The distance (m) of each point of the scan from the point of the same beam in its noise-free reference; NaN where
// either has no point. Points are joined by ring, column and number of the
// return, which an organised scan knows by its order. Empty where
// they cannot be joined; then `why` says to the user what the scans lack.
std::vector<float> referenceErrors(const Scan& scan, const Scan& reference, std::string& why);

// The difference (m) of each point's range from `range_true`; NaN where a point has no range. Ranges count from where
// the beam starts; without a beam table, from the sensor's origin. Empty where the scan lacks the column `range_true`.
std::vector<float> rangeErrors(const Scan& scan, const BeamTable* beams);

}  // namespace scanmill
