#pragma once

// The fixed errors of a sensor's lasers, from flat patches: neighbouring rings that see one plane should give one
// plane, and one brightness.

#include <cstddef>
#include <vector>

#include "sensors/beams.h"
#include "study/noise/flat_patches.h"
#include "study/noise/recorded_scan.h"

namespace scanmill {

// How much rings differ. A plane takes up what all rings, or a slope over them, have in common: of offsets only what
// differs from neighbour to neighbour can be seen.
struct RingSpread {
  std::vector<double> ofRing;  // 0 where no patch tells
  double sigma = 0;            // standard deviation over the rings, without what noise adds
  // Correlation of the errors that the odd patches give with those of the even ones: near 1 where they belong to the
  // sensor, near 0 where they are noise.
  double agreement = 0;
  std::size_t rings = 0;  // that patches tell of
};

struct RingErrors {
  RingSpread range;  // m
  RingSpread gain;   // natural logarithm; empty where scans have no intensities
};

// Least squares over all patches at once: the ranges' differences from a plane of each patch's own and an offset of
// each ring, and the logarithms of the intensities from a slope of each patch's own over its rings
// and a gain of each ring. Offsets far beyond the noise leave few flat patches, and those are the more even ones.
RingErrors fitRingErrors(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                         const std::vector<FlatPatch>& patches);

// Errors that agree as well as this are the sensor's own.
constexpr double kOwnErrors = 0.5;

}  // namespace scanmill
