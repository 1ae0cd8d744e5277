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
  std::string name;              // the file's name
  std::vector<double> range;     // m along each beam to its first return, from the beam's own origin; NaN without one
  std::vector<float> intensity;  // of each beam, zero without a return; empty where the scan has no intensities
  Pose scanFromSensor;           // the frame in which the scan gives its points, which may differ from the sensor's
  std::size_t returns = 0;
};

// Gives each point of a scan to its beam, by its place in an organised scan, by its ring and column, or by its ring and
// azimuth, to the nearest column. Only a beam's
// first return is taken: the others come from what is behind edges, and flat surfaces have one. Where the frame of the
// points lies against the beams is found from the points, since recordings often leave the sensor's own offsets out.
// Throws InputError, which begins with the name, where the scan has another size than the sensor, has no rings, or is
// empty, or where its points do not lie on the sensor's beams.
RecordedScan rangesAlong(const Scan& scan, const BeamTable& beams, const std::string& name);

// The step (m) in which ranges are reported: they are multiples of it plus a constant. 0 where no step was found.
double rangeStep(const std::vector<RecordedScan>& scans);

}  // namespace scanmill
