#pragma once

// How far the points of a scan lie from where they would be without noise.

#include <string>
#include <vector>

#include "scan/scan.h"
#include "sensors/beams.h"

namespace scanmill {

// m, one per point: the distance between the point of a beam's return and the twin's; NaN where either has none. Points
// are joined by their keys: ring, column and number of the return, which an organised scan knows by its order. Empty
// where that cannot be, and then `why` says so, for the one who made the scans.
std::vector<float> twinErrors(const Scan& scan, const Scan& twin, std::string& why);

// m, one per point: by how much its range differs from `range_true`; NaN where it has none. Ranges count from where
// the beam starts: without a table, from the sensor's origin. Empty where the scan lacks the column.
std::vector<float> rangeErrors(const Scan& scan, const BeamTable* beams);

}  // namespace scanmill
