#pragma once

// Measures the fixed errors of a sensor's lasers on flat patches: neighbouring rings that see one plane should measure
// the same plane, and the same brightness.

#include <cstddef>
#include <vector>

#include "sensors/beams.h"
#include "study/noise/flat_patches.h"
#include "study/noise/recorded_scan.h"

namespace scanmill {

// How much rings differ. The plane fitted to a patch absorbs what its rings have in common, and any slope over them:
// only differences between neighbouring rings can be seen.
struct RingSpread {
  std::vector<double> ofRing;  // error of each ring; 0 if no patch has the ring
  double sigma = 0;            // standard deviation over the rings, with the part due to noise removed
  // Correlation of the errors from the odd patches with the errors from the even patches: near 1 if the errors belong
  // to the sensor, near 0 if they are noise.
  double agreement = 0;
  std::size_t rings = 0;  // number of rings that patches cover
};

struct RingErrors {
  RingSpread range;  // m
  RingSpread gain;   // natural logarithm of the gain; empty if scans have no intensities
};

// Fits all patches at once by least squares: the differences of the ranges from a separate plane per patch plus an
// offset per ring, and the logarithms of the intensities as a separate slope over the rings per patch plus a gain per
// ring. If offsets are far larger than the noise, few patches pass as flat, and those have smaller offsets than the
// rest.
RingErrors fitRingErrors(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                         const std::vector<FlatPatch>& patches);

// Errors with at least this agreement count as the sensor's own.
constexpr double kOwnErrors = 0.5;

}  // namespace scanmill
