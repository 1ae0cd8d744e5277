#pragma once

// A recorded scan as its sensor measured it: ranges along known beams.

#include <cstddef>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scan/scan.h"
#include "sensors/beams.h"

namespace scanmill {

struct RecordedScan {
  std::string name;              // the file's name
  std::vector<double> range;     // m along each beam to its first return, from the beam's own origin; NaN: no return
  std::vector<float> intensity;  // intensity of each beam, zero without a return; empty if the scan has no intensities
  Pose scanFromSensor;           // pose of the sensor in the frame of the scan's points, which may be another frame
  std::size_t returns = 0;
};

// Assigns each point of a scan to a beam: by its position in an organised scan, by its ring and column, or by its ring
// and the column nearest to its azimuth. Only the first return of a beam is used: later returns come from behind edges,
// and a flat surface gives only one. The pose of the points' frame relative to the beams is found from the points,
// since recordings often leave out the sensor's own offsets. Throws InputError that begins with `name` if the scan has
// another size than the sensor, has no rings or is empty, or if its points do not lie on the sensor's beams.
RecordedScan rangesAlong(const Scan& scan, const BeamTable& beams, const std::string& name);

// Returns the step (m) to which ranges are rounded: they are multiples of it plus a constant. 0 if no step was found.
double rangeStep(const std::vector<RecordedScan>& scans);

}  // namespace scanmill
