#pragma once

// A recorded scan as what its sensor measured: ranges along known beams.

#include <cstddef>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scan/scan.h"
#include "sensors/beams.h"

namespace scanmill {

struct RecordedScan {
  std::string name;              // of its file
  std::vector<double> range;     // m along each beam, from the beam's own origin; NaN: no return
  std::vector<float> intensity;  // likewise, zero without a return; or empty
  Pose scanFromSensor;           // the frame that the points are given in, which may be turned against the sensor's
  std::size_t returns = 0;
};

// Each point goes to its beam by its place in an organised scan, or by its ring and column. How the points' frame lies
// against the beams is found by itself: recordings often leave the sensor's own offsets out. Throws InputError that
// begins with the name: where the scan has another size than the sensor or no ring and column, is empty, or where its
// points do not lie on the sensor's beams.
RecordedScan rangesAlong(const Scan& scan, const BeamTable& beams, const std::string& name);

// The step in which ranges are reported (m): they are multiples of it, plus a constant. 0: none was found.
double rangeStep(const std::vector<RecordedScan>& scans);

}  // namespace scanmill
