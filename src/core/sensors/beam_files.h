#pragma once

// Reads tables of a sensor's lasers and of their firing times, one laser per line.

#include <filesystem>
#include <vector>

#include "base/error.h"

namespace scanmill {

struct FormatSupport;
const FormatSupport& beamTableFormat();

struct Laser {
  double elevation = 0;  // deg, upwards from the horizontal
  double azimuth = 0;    // deg, counter-clockwise
  double left = 0;       // m, offset of the beam's origin to the left: see origin_left_m in sensor.h
  double up = 0;         // m, offset of the beam's origin upwards: see origin_up_m in sensor.h
  double firing = 0;     // us, firing time after the start of the column
};

// Reads the lasers of a table. The table's first line names the columns: either the columns of Hesai's angle correction
// files (Channel or Laser id, Elevation, Azimuth; degrees, azimuths clockwise), or elevation_deg and optionally
// azimuth_offset_deg (counter-clockwise), origin_left_m, origin_up_m and firing_time_us. The rows may come in any order
// if the table has channels, which become the rings. Throws InputError with the line.
std::vector<Laser> readBeamTable(const std::filesystem::path& file);

// Returns the firing time of each laser (us after the earliest laser). The file is one of Hesai's firetime correction
// files (Channel, fire time in us or ns) or a table with a column firing_time_us. Throws InputError with the line, also
// if a file gives several states of the sensor with different firing times.
std::vector<double> readFiringTable(const std::filesystem::path& file);

}  // namespace scanmill
