#pragma once

// Beams are data: a sensor is a table of directions, origins, firing times and ring numbers.

#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"

namespace scanmill {

// One turn of a sensor. Beam index = ring * columns + column; column 0 fires first. Sensor frame: x forward, y left,
// z up; azimuth counts from x towards y (counter-clockwise seen from above), whatever way the sensor turns.
struct BeamTable {
  std::string model;   // "OS1-128"
  std::string source;  // of the figures
  std::uint32_t rings = 0;
  std::uint32_t columns = 0;

  std::vector<Vec3d> direction;  // unit
  std::vector<Vec3f> origin;     // m; empty where all are zero
  std::vector<float> time;       // s since the start of the turn

  double minRange = 0;  // m; nearer surfaces are not reported (the beam is a miss: they still block it)
  double maxRange = 0;  // m; a hit at exactly maxRange counts
  double period = 0;    // s, one turn

  // How the table was made, for the manifest: fillBeams() makes the three tables above again from what follows.
  bool clockwise = false;             // seen from above
  double firstAzimuth = 0;            // rad, of column 0 before offsets
  double field = 2 * kPi;             // rad, horizontal; in a full turn no column repeats the first
  std::vector<double> elevation;      // rad, per ring
  std::vector<double> azimuthOffset;  // rad, per ring
  std::vector<double> firingOffset;   // s, per ring
  double originOffset = 0;            // m, beam origin to the axis of rotation, along the beam's azimuth
  double originHeight = 0;            // m, beam origin above the sensor frame's origin
  bool topDown = false;               // ring 0 is the highest beam

  std::size_t size() const { return std::size_t{rings} * columns; }

  bool fullTurn() const { return field > 2 * kPi - 1e-9; }
  // Where the head points when a column fires, before the ring's offset (rad).
  double azimuth(std::uint32_t column) const;
  // When a column fires, before the ring's offset (s since the start of the turn).
  double columnTime(std::uint32_t column) const { return column * columnPeriod(); }
  double columnPeriod() const { return period * (field / (2 * kPi)) / columns; }
};

// Computes direction, origin and time from the compact description.
void fillBeams(BeamTable& table);

}  // namespace scanmill
