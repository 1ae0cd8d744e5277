#pragma once

// Draws a picture of a scan whose points are coloured by their errors.

#include <string>

#include "evaluate/beam_errors.h"
#include "scan/hits.h"

namespace scanmill {

// Draws the true points, coloured by the range error of the tested method. The colour map viridis shows errors from 1
// mm to 1 m on a logarithmic scale. False negatives, false positives (drawn at the tested hit) and beams with a wrong
// label have separate colours. Returns the contents of a PNG file.
std::string drawErrors(const TrueShot& truth, const Hits& tested);

}  // namespace scanmill
