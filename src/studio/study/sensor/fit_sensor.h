#pragma once

// Recovers a sensor's beams from its scans.

#include <cstdint>
#include <string>
#include <vector>

#include "scan/scan.h"

namespace scanmill {

// What scans say of the sensor that made them; see sensors/beams.h for the terms. Angles in rad, lengths in m.
struct SensorFit {
  std::uint32_t rings = 0, columns = 0;
  bool clockwise = false;
  double firstAzimuth = 0;
  double field = 0;                   // 2 pi: a full turn
  std::vector<double> elevation;      // per ring
  std::vector<double> azimuthOffset;  // per ring
  double originOffset = 0;            // from the axis, 0 where the scans do not tell it from none
  double originHeight = 0;            // likewise
  std::vector<double> firing;         // s, per ring; empty: the scans have no times
  double period = 0;                  // s, of a turn; 0: the scans have no times
  double nearest = 0, farthest = 0;   // of all points
  std::uint64_t points = 0;
  double elevationSpread = 0, azimuthSpread = 0;  // medians of how far points lie from their beams
  std::vector<std::uint32_t> bareRings;           // without enough points: between, or beyond, their neighbours
};

// The scans are those of one sensor, in its own frame, not de-skewed, and know which beam each point belongs to: they
// are organised, or have the columns ring and column. Positions of one beam lie on one ray, whatever noise the range
// has: heights over distances from the axis are lines, whose slopes are the elevations, and whose intercepts tell where
// beams start. All figures are medians or trimmed fits. Throws InputError that says what is missing.
SensorFit fitSensor(const std::vector<Scan>& scans);

// The sensor's file. `source` goes into it.
std::string sensorYaml(const SensorFit& fit, const std::string& source);

}  // namespace scanmill
