#pragma once

// Sensors whose beams do not lie on cones about an axis: flash sensors, prisms that turn against each other, and what a
// table lists beam by beam.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <utility>

#include "config/fields.h"
#include "sensors/beams.h"

namespace scanmill {

// A table with a line for each beam, whose first line names the columns: azimuth_deg and elevation_deg, and any of
// time_us (since the start of the revolution), ring, column, and origin_x_m, origin_y_m, origin_z_m. With ring and
// column, which count from 0, every pair is named once; without them all are one ring, in the order of the lines.
// Columns fire one after the other. Throws InputError with the file and its line.
struct ListedSensor {
  std::uint32_t rings = 0, columns = 0;
  ListedBeams beams;
};
ListedSensor readListedBeams(const std::filesystem::path& file);

// The pixels of a flash sensor, which all fire at once: a grid that is even in the plane square to the middle of its
// field, as an image's is. `azimuth` (rad) is of the middle; `field` (rad) reaches from the middle of the first column
// to that of the last, below pi; columns go from left to right where `clockwise`. `elevation` (rad): of each row in the
// middle.
ListedBeams flashBeams(double azimuth, double field, bool clockwise, std::uint32_t columns,
                       const std::vector<double>& elevation);

// From YAML: {field_deg: 38.4, turns_hz: [121.6, -77.7], share: 0.5, phase_deg: [0, 0]}: two prisms that turn so often
// a second; the first deflects by that share of half the field. Throws InputError.
Rosette readRosette(const Value& value);

}  // namespace scanmill
