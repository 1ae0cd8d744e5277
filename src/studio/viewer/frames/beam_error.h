#pragma once

// Measures how far noise has moved the points of a scan.

#include <string>
#include <vector>

#include "scan/scan.h"
#include "sensors/beams.h"

namespace scanmill {

// Returns the distance (m) of each point from the point of the same beam and return in the noise-free reference. The
// distance is NaN if the beam has no return in the reference, and for false positives, which come from no surface.
// Corresponding points have the same ring, column and return number; in an organised scan these follow from the
// position in the image.
//
// The return numbers of a beam start with the nearest return in each scan. They identify the same surface only if the
// beam has the same number of returns in both scans. If drop-out or false positives have changed the returns, or if a
// scan does not number its returns, each point is compared with the nearest of the beam's returns in the reference.
// This return is from the same surface as long as the noise is less than half the distance between two surfaces.
//
// Returns nothing if the scans cannot be compared; then `why` receives the reason as a text for the user.
std::vector<float> referenceErrors(const Scan& scan, const Scan& reference, std::string& why);

// Returns the absolute difference (m) between each point's range and its column `range_true`; NaN if a point has no
// range. Ranges are measured from the beam's origin, or from the sensor's origin if `beams` is null or the scan does
// not assign points to beams. Returns nothing if the scan has no column `range_true`.
std::vector<float> rangeErrors(const Scan& scan, const BeamTable* beams);

}  // namespace scanmill
