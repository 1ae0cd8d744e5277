#pragma once

// How long scans take by the number of rings: a fixed cost and a slope.

#include <memory>

#include "sensors/beams.h"
#include "study/tradeoff/study.h"

namespace scanmill {

// The same sensor with so many rings, evenly between its highest and lowest one, without offsets between rings. Top
// down where the sensor is. Throws Error for fewer than two.
std::shared_ptr<const BeamTable> withRings(const BeamTable& beams, std::uint32_t rings);

// Fills in the fit: seconds = fixed + perRing * rings by least squares of relative errors, so that fast scans count as
// much as slow ones. At least two different numbers of rings.
void fitRings(RingFit& fit);

}  // namespace scanmill
