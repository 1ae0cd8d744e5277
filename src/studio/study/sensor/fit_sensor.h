#pragma once

// Estimates a sensor's beam table from its scans.

#include <cstdint>
#include <string>
#include <vector>

#include "scan/scan.h"

namespace scanmill {

// The geometry and timing of a sensor, estimated from its scans; sensors/beams.h explains the terms. Angles are in
// radians, lengths in metres.
struct SensorFit {
  std::uint32_t rings = 0, columns = 0;
  bool clockwise = false;
  double firstAzimuth = 0;
  double field = 0;                   // horizontal field of view; 2 pi for a full revolution
  std::vector<double> elevation;      // elevation of each ring
  std::vector<double> azimuthOffset;  // azimuth offset of each ring
  double originOffset = 0;            // horizontal distance of beam origins from the axis; 0 if it is not significant
  double originHeight = 0;            // height of beam origins; 0 if it is not significant
  std::vector<double> firing;         // firing time of each ring (s); empty if the scans have no times
  double period = 0;                  // duration of a revolution (s); 0 if the scans have no times
  double nearest = 0, farthest = 0;   // least and largest range of all points
  std::uint64_t points = 0;
  double elevationSpread = 0, azimuthSpread = 0;  // median angle between points and their beams (rad)
  std::vector<std::uint32_t> bareRings;  // rings with too few points; their elevations are interpolated or extrapolated
};

// Estimates a sensor from its scans. The scans must be in the sensor's frame, not deskewed, and assign each point to a
// beam: they are organised, or have the columns ring and column. All points of a beam lie on one line, whatever the
// noise of the ranges, so in each ring the height of a point is linear in its distance from the axis. The slopes and
// intercepts of these lines give the origin of the beams; angles and times are medians. Throws InputError if the scans
// do not suffice; the message says what is missing.
SensorFit fitSensor(const std::vector<Scan>& scans);

// Returns the text of a sensor file. A comment in it names `source`, a description of the scans, as its origin.
std::string sensorYaml(const SensorFit& fit, const std::string& source);

}  // namespace scanmill
