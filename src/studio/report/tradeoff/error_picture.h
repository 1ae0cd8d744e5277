#pragma once

// A picture of a scan whose points are coloured by their errors.

#include <string>

#include "evaluate/beam_errors.h"
#include "scan/hits.h"

namespace scanmill {

// Draws the truth's points, coloured by the tested method's range error: the colour map viridis spans 1 mm to 1 m by
// the logarithm of the error. False negatives, false positives (drawn at the hit of the tested method) and beams with a
// wrong label have colours of their own. Returns the bytes of a PNG file.
std::string drawErrors(const TrueShot& truth, const Hits& tested);

}  // namespace scanmill
