#pragma once

// A picture of a scan whose points are coloured by their errors.

#include <string>

#include "evaluate/beam_errors.h"
#include "scan/hits.h"

namespace scanmill {

// Draws the truth's points, coloured by the tested method's range error: the colour map viridis spans 1 mm to 1 m by
// the logarithm of the error. False negatives, false positives (drawn where the tested method hits) and beams with
// another label have colours of their own. The result is a PNG file's bytes.
std::string drawErrors(const TrueShot& truth, const Hits& tested);

}  // namespace scanmill
