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

// Reads a table with a line for each beam. Its first line names the columns: azimuth_deg and elevation_deg, and any of
// time_us (since the start of the revolution), ring, column, and origin_x_m, origin_y_m, origin_z_m. With ring and
// column, which count from 0, every pair must occur once; without them all beams are one ring, in the order of the
// lines. No column may fire before the one that precedes it. Throws InputError with the file and its line.
struct ListedSensor {
  std::uint32_t rings = 0, columns = 0;
  ListedBeams beams;
};
ListedSensor readListedBeams(const std::filesystem::path& file);

// Returns the pixels of a flash sensor, which all fire at once. Like those of a pinhole image they form an even grid in
// the plane perpendicular to the middle of the field. `azimuth` (rad): of the field's middle. `field` (rad, below pi):
// from the middle of the first column to that of the last; columns go from left to right if `clockwise`. `elevation`
// (rad): of each row, at the field's middle.
ListedBeams flashBeams(double azimuth, double field, bool clockwise, std::uint32_t columns,
                       const std::vector<double>& elevation);

// Reads {field_deg: 38.4, turns_hz: [121.6, -77.7], share: 0.5, phase_deg: [0, 0]} of YAML: two prisms that rotate with
// these frequencies; the first deflects by `share` of half the field, the second by the rest. Throws InputError.
Rosette readRosette(const Value& value);

}  // namespace scanmill
