#pragma once

// Sensors whose beams do not lie on cones about an axis: flash sensors, rotating prisms, mirrors that scan line by
// line, and tables that list every beam.

#include <cstdint>
#include <filesystem>

#include "config/fields.h"
#include "sensors/beams.h"

namespace scanmill {

// A sensor read from a table with one line per beam. The first line names the columns: azimuth_deg and elevation_deg
// (or zenith_deg, from straight up), and optionally time_us (since the start of the revolution; or time_s, time_ms,
// time_ns), ring, column, and origin_x_m, origin_y_m, origin_z_m. Units may also be written as "Time/s" or "Time [s]".
// Rings and columns are numbered from 0, and every pair of ring and column must occur once; without them all beams form
// one ring, in the order of the lines. No column may fire before its predecessor. readListedBeams() throws InputError
// with the file and, if the fault is in one line, the line.
struct ListedSensor {
  std::uint32_t rings = 0, columns = 0;
  ListedBeams beams;
};
ListedSensor readListedBeams(const std::filesystem::path& file);

// Returns the values times the factor, for changes of units.
std::vector<double> scaledBy(double factor, std::vector<double> values);

// Returns the pixels of a flash sensor, which all fire at once. The beams form an even grid in the plane perpendicular
// to the middle of the field of view, as the pixels of a pinhole camera do. `azimuth` (rad): middle of the field of
// view. `field` (rad, below pi): angle from the middle of the first column to the middle of the last column. Columns go
// from left to right if `clockwise`. `elevation` (rad): elevation of each row at the middle of the field of view.
ListedBeams flashBeams(double azimuth, double field, bool clockwise, std::uint32_t columns,
                       const std::vector<double>& elevation);

// Reads {field_deg: 38.4, turns_hz: [121.6, -77.7], phase_deg: [0, 0]} from YAML: one to four prisms that rotate with
// these frequencies. Together they deflect the beam by up to half the field of view, each by the same angle;
// `deflection_deg` states the angle of each in place of `field_deg`. Optional keys: laser_azimuth_deg: [0, 1] and
// laser_elevation_deg: [0, 0.2] deflect the beams of several lasers, which all pass the prisms; mirror: {tilt_deg: 56,
// turns_hz: 180, phase_deg: 0} is Rosette::mirror. Throws InputError.
Rosette readRosette(const Value& value);

// A mirror that scans zones side by side, all at once, line by line from the top (a laser for each zone).
struct RasterScan {
  std::vector<double> zones;   // rad, azimuth of the middle of each zone
  double width = 0;            // rad, from the first to the last beam of a line
  double top = 0, bottom = 0;  // rad, elevation of the first and the last line
  std::uint32_t lines = 0;
  double lineTime = 0;  // s, time from the first to the last beam of a line; 0: lines follow each other without a pause
  bool alternate = false;  // true: every other line is scanned from right to left
};

// Reads {zones_deg: [24, 0, -24], width_deg: 24, top_deg: 12.5, bottom_deg: -12.5, lines: 126, line_us: 625, alternate:
// false} from YAML; the last two are optional. Throws InputError.
RasterScan readRasterScan(const Value& value);

// Returns the beams of a raster with a ring for each zone. The columns are numbered in the order in which they fire:
// all of the first line, from left to right, then those of the next line. `columns`: a multiple of the lines. `period`:
// time in which all lines are scanned (s).
ListedBeams rasterBeams(const RasterScan& raster, std::uint32_t columns, double period);

}  // namespace scanmill
