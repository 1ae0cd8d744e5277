#pragma once

// Models how the time of a scan depends on the number of rings: a fixed cost and a cost per ring.

#include <memory>

#include "sensors/beams.h"
#include "study/tradeoff/study.h"

namespace scanmill {

// Returns the same sensor with this number of rings, evenly spread between its highest and lowest ring, in the sensor's
// own order and without offsets between rings. Throws Error for fewer than two rings.
std::shared_ptr<const BeamTable> withRings(const BeamTable& beams, std::uint32_t rings);

// Fits seconds = fixed + perRing * rings to the timings by least squares of relative errors, so that fast scans count
// as much as slow ones. Throws Error if the timings have fewer than two different numbers of rings.
void fitRings(RingFit& fit);

}  // namespace scanmill
