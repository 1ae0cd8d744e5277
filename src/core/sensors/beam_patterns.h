#pragma once

// Sensors whose beams do not lie on cones about an axis: flash sensors, rotating prisms, mirrors that scan line by
// line, line scanners of aircraft, and tables that list every beam.

#include <cstdint>
#include <filesystem>

#include "config/fields.h"
#include "sensors/beams.h"

namespace scanmill {

constexpr std::uint32_t kMostRings = 8192;  // of any sensor
constexpr std::uint32_t kMostColumns = 65536;

// A sensor that is read from a table with one line per beam. docs/keys.md explains the columns (key `beams`). Rings and
// columns are numbered from 0, and every pair of ring and column must occur once; without these numbers all beams form
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
// from left to right if `clockwise`, else from right to left. `elevation` (rad): per row, at the field's middle.
ListedBeams flashBeams(double azimuth, double field, bool clockwise, std::uint32_t columns,
                       const std::vector<double>& elevation);

// Reads the key `rosette` of a sensor, which docs/keys.md explains. Throws InputError.
Rosette readRosette(const Value& value);

// A mirror that scans zones side by side, all at the same time with one laser per zone, line by line from the top.
struct RasterScan {
  std::vector<double> zones;   // rad, azimuth of the middle of each zone
  double width = 0;            // rad, from the first to the last beam of a line
  double top = 0, bottom = 0;  // rad, elevation of the first and the last line
  std::uint32_t lines = 0;
  double lineTime = 0;  // s, time from the first to the last beam of a line; 0: lines follow each other without a pause
  bool alternate = false;  // true: every other line is scanned from right to left
};

// Reads the key `raster` of a sensor, which docs/keys.md explains. Throws InputError.
RasterScan readRasterScan(const Value& value);

// Returns the beams of a raster, with one ring per zone. The columns are numbered in the order in which they fire: the
// first line from left to right, then the next line (from right to left if lines alternate), and so on. `columns`: a
// multiple of the number of lines. `period`: time in which all lines are scanned (s).
ListedBeams rasterBeams(const RasterScan& raster, std::uint32_t columns, double period);

// A line scanner, which looks along -z; x is the direction of flight (Baltsavias, "Airborne laser scanning: basic
// relations and formulas", ISPRS Journal 54, 1999, figure 2). A line lies in the plane of y and z, from left to right;
// a palmer scanner's lines are circles that begin at the left and pass the front.
struct LineScan {
  // Rotating: equal angles in equal times. Oscillating: the angle is a sinusoid of time, and every other line goes from
  // right to left. Palmer: the beam turns about -z on a cone.
  enum class Mirror { Rotating, Oscillating, Palmer };
  Mirror mirror = Mirror::Rotating;
  double field = 0;         // rad, angle of a line, or full angle of the cone
  std::uint32_t lines = 0;  // in a frame
  double lineTime = 0;      // s, time of the pulses of a line
};

// Reads the key `lines` of a sensor, which docs/keys.md explains. `period`: duration of a frame (s). Throws InputError.
LineScan readLineScan(const Value& value, double period);

// Returns the beams of a frame in the order in which they fire, as one ring. The pulses fire at equal intervals,
// without those of the pauses between lines. `columns`: number of pulses in a frame.
ListedBeams lineBeams(const LineScan& scan, std::uint32_t columns, double period);

}  // namespace scanmill
