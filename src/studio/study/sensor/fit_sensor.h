#pragma once

// Recovers a sensor's beams from its scans.

#include <cstdint>
#include <string>
#include <vector>

#include "scan/scan.h"

namespace scanmill {

// A sensor's geometry and timing as its scans show them; see sensors/beams.h for the terms. Angles in rad, lengths in
// m.
struct SensorFit {
  std::uint32_t rings = 0, columns = 0;
  bool clockwise = false;
  double firstAzimuth = 0;
  double field = 0;                   // 2 pi: a full revolution
  std::vector<double> elevation;      // per ring
  std::vector<double> azimuthOffset;  // per ring
  double originOffset =
      0;  // distance of the beams' origins from the axis (m); 0 if the scans do not show that it differs from 0
  double originHeight = 0;     // height of the beams' origins (m); 0 if the scans do not show that it differs from 0
  std::vector<double> firing;  // s, per ring; empty: the scans have no times
  double period = 0;           // s, of a revolution; 0: the scans have no times
  double nearest = 0, farthest = 0;  // ranges of all points
  std::uint64_t points = 0;
  double elevationSpread = 0, azimuthSpread = 0;  // medians of the distances of points from their beams (rad)
  std::vector<std::uint32_t> bareRings;           // with too few points: interpolated or extrapolated
};

// Fits a sensor to its scans. The scans are in the sensor's own frame, not de-skewed, and assign each point to a beam:
// they are organised, or have the columns ring and column. The points of one beam lie on one ray, whatever the noise of
// the ranges: the height is linear in the distance from the axis, the slope gives the elevation, and the intercept
// gives the origin of the beam. All figures are medians or trimmed fits. Throws InputError that says what is missing.
SensorFit fitSensor(const std::vector<Scan>& scans);

// Returns the text of the sensor's file, which names `source` as its origin.
std::string sensorYaml(const SensorFit& fit, const std::string& source);

}  // namespace scanmill
