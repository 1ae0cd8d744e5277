#pragma once

// Sensors whose beams do not lie on cones about an axis: flash sensors, pairs of rotating prisms, and tables that list
// every beam.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <utility>

#include "config/fields.h"
#include "sensors/beams.h"

namespace scanmill {

// A sensor read from a table with one line per beam. The first line names the columns: azimuth_deg and elevation_deg,
// and optionally time_us (since the start of the revolution), ring, column, and origin_x_m, origin_y_m, origin_z_m.
// Rings and columns are numbered from 0, and every pair of ring and column must occur once; without them all beams form
// one ring, in the order of the lines. No column may fire before its predecessor. readListedBeams() throws InputError
// with the file and, if the fault is in one line, the line.
struct ListedSensor {
  std::uint32_t rings = 0, columns = 0;
  ListedBeams beams;
};
ListedSensor readListedBeams(const std::filesystem::path& file);

// Returns the pixels of a flash sensor, which all fire at once. The beams form an even grid in the plane perpendicular
// to the middle of the field of view, as the pixels of a pinhole camera do. `azimuth` (rad): middle of the field of
// view. `field` (rad, below pi): angle from the middle of the first column to the middle of the last column. Columns go
// from left to right if `clockwise`. `elevation` (rad): elevation of each row at the middle of the field of view.
ListedBeams flashBeams(double azimuth, double field, bool clockwise, std::uint32_t columns,
                       const std::vector<double>& elevation);

// Reads {field_deg: 38.4, turns_hz: [121.6, -77.7], share: 0.5, phase_deg: [0, 0]} from YAML: two prisms that rotate
// with these frequencies. The first prism deflects the beam by `share` of half the field of view, the second by the
// remainder. Throws InputError.
Rosette readRosette(const Value& value);

}  // namespace scanmill
