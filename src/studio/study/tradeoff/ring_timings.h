#pragma once

// Models the time of a scan as a fixed time plus a time per ring.

#include <memory>

#include "sensors/beams.h"
#include "study/tradeoff/study.h"

namespace scanmill {

// Returns the sensor with another number of rings. The new rings are evenly spread from the sensor's lowest to its
// highest elevation, are numbered in the same direction as the sensor's rings, and have no offsets between rings.
// Throws Error for fewer than two rings.
std::shared_ptr<const BeamTable> withRings(const BeamTable& beams, std::uint32_t rings);

// Fits seconds = fixed + perRing * rings to the timings by least squares of relative errors, so that fast and slow
// scans have the same weight. Throws Error if the timings have fewer than two different numbers of rings.
void fitRings(RingFit& fit);

}  // namespace scanmill
