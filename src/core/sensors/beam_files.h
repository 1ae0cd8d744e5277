#pragma once

// Reads tables of a sensor's lasers and of their firing times, one laser per line.

#include <filesystem>
#include <vector>

#include "base/error.h"

namespace scanmill {

struct Laser {
  double elevation = 0;  // deg
  double azimuth = 0;    // deg, counter-clockwise
  double left = 0;       // m, offset of the beam's origin: see origin_left_m in sensor.h
  double up = 0;         // m
  double firing = 0;     // us after the column's first laser
};

// Reads the lasers of a table. Its first line names the columns: either those of Hesai's angle correction files
// (Channel or Laser id, Elevation, Azimuth; degrees, azimuths clockwise), or elevation_deg and any of
// azimuth_offset_deg (counter-clockwise), origin_left_m, origin_up_m and firing_time_us. Channels, which become the
// rings, may come in any order. Throws InputError with the line.
std::vector<Laser> readBeamTable(const std::filesystem::path& file);

// Returns when each laser fires, in us after the first: from Hesai's firetime correction files (Channel, fire time in
// us or ns) or a table with a column firing_time_us. Throws InputError with the line, also for files of several states
// whose firing times differ.
std::vector<double> readFiringTable(const std::filesystem::path& file);

}  // namespace scanmill
