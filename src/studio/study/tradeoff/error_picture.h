#pragma once

// A scan whose points are coloured by how far they are off.

#include <string>

#include "evaluate/beam_errors.h"
#include "study/tradeoff/study.h"

namespace scanmill {

// The truth's points, coloured by the tested method's range error: viridis from 1 mm or less to 1 m or more by the
// logarithm; beams that only the truth meets, those that only the tested method meets (where it meets them) and those
// whose label differs have colours of their own.
ErrorPicture drawErrors(const Setting& setting, const TrueShot& truth, const Hits& tested);

}  // namespace scanmill
