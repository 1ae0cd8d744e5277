#pragma once

// Converts recorded scans to ranges along the known beams of the sensor.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scan/scan.h"
#include "sensors/beams.h"

namespace scanmill {

struct RecordedScan {
  std::string name;              // name of the file
  std::vector<double> range;     // distance from each beam's origin to its first return (m); NaN: no return
  std::vector<float> raised;     // elevation of each beam's point above the beam (rad)
  std::vector<float> intensity;  // intensity of each beam; 0 if it has no return; empty if the scan has no intensities
  Pose scanFromSensor;           // pose of the sensor in the frame of the scan's points
  std::size_t returns = 0;
};

// Returns the derivative of a beam's direction by its elevation: a unit vector upwards, perpendicular to the beam.
inline Vec3d upwardsFrom(const Vec3d& direction) {
  const double level = std::max(std::hypot(direction.x, direction.y), 1e-6);
  return {-direction.z * direction.x / level, -direction.z * direction.y / level, level};
}

// Assigns each point of a scan to a beam: in an organised scan by the position in the image, otherwise by the columns
// `ring` and `column` or, without `column`, by ring and azimuth. Only the first return of a beam is used, since later
// returns occur at edges and not on flat surfaces. The sensor's pose in the frame of the points is estimated, since
// recordings often do not state it. Throws InputError if the scan's size is not the sensor's, if rings are unknown, if
// returns are too few, or if points are not on the sensor's beams; the message starts with `name`.
RecordedScan rangesAlong(const Scan& scan, const BeamTable& beams, const std::string& name);

// Returns the step (m) to which the sensor rounds ranges: all ranges differ by multiples of it. 0: no step is found.
double rangeStep(const std::vector<RecordedScan>& scans);

}  // namespace scanmill
