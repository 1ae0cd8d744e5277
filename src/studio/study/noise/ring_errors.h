#pragma once

// Measures the constant errors of a sensor's lasers on flat patches. If lasers had no such errors, neighbouring rings
// on the same surface would show the same plane and the same intensity.

#include <cstddef>
#include <vector>

#include "sensors/beams.h"
#include "study/noise/flat_patches.h"
#include "study/noise/recorded_scan.h"

namespace scanmill {

// The errors of rings, which differ from ring to ring. The plane that is fitted to each patch absorbs errors that its
// rings have in common and errors that grow linearly over its rings. Only differences between neighbouring rings can be
// measured.
struct RingSpread {
  std::vector<double> ofRing;  // error of each ring; 0 if no patch contains the ring
  double sigma = 0;            // standard deviation between rings, after removing the part due to noise
  // Correlation between the errors measured on the odd patches and those measured on the even patches. Near 1: the
  // errors belong to the sensor. Near 0: they are noise.
  double agreement = 0;
  std::size_t rings = 0;  // number of rings that both the odd and the even patches contain
};

struct RingErrors {
  RingSpread range;  // errors of the range (m)
  RingSpread gain;   // errors of the gain (natural logarithm); empty if scans have no intensities
};

// Fits all patches together by least squares. The model of the range differences is a plane per patch plus an offset
// per ring. The model of the intensities' logarithms is a constant and a slope over the rings per patch plus a gain per
// ring. If offsets are much larger than the noise, they are underestimated: only patches with small offsets then count
// as flat.
RingErrors fitRingErrors(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                         const std::vector<FlatPatch>& patches);

// Least RingSpread::agreement for which errors are attributed to the sensor.
constexpr double kOwnErrors = 0.5;

}  // namespace scanmill
