#pragma once

// Reads calibration files with the beams of one sensor unit: the files of Velodyne's ROS drivers (.yaml), Ouster's
// metadata (.json), and tables of beams such as Hesai's (.csv).

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "config/value.h"

namespace scanmill {

struct FormatSupport;
extern const FormatSupport kVelodyneFormat;

// Returns the sensor map `value` with its key `calibration` replaced by keys from the calibration file: elevation_deg,
// ring_order, azimuth_offset_deg, origin_left_m and origin_up_m. Further keys are added unless the map has them:
// firing_time_us (tables) and model, columns, rate_hz, direction, first_azimuth_deg, field_deg, origin_offset_m and
// origin_height_m (Ouster). The key `source` then also names the file. A map without the key `calibration` is returned
// unchanged. Velodyne's lasers are sorted from top to bottom, or from bottom to top if the preset has this ring order;
// other lasers keep the order of their file. Throws InputError with the place, also if the map has both `calibration`
// and one of the first five keys. `preset`: the preset that the map overrides; null if there is no preset.
[[nodiscard]] Value withCalibration(const Value& value, const Value* preset = nullptr);

extern const FormatSupport kBeamTableFormat;

struct Laser {
  double elevation = 0;  // deg, upwards from the horizontal
  double azimuth = 0;    // deg, counter-clockwise
  double left = 0;       // m, offset of the beam's origin to the left: see origin_left_m in sensor.h
  double up = 0;         // m, offset of the beam's origin upwards: see origin_up_m in sensor.h
  double firing = 0;     // us, firing time after the start of the column
};

// Reads the lasers of a table, by Hesai or written by the user: see kBeamTableFormat. The rows may come in any order
// if the table has channels, which become the rings. Throws InputError with the line.
std::vector<Laser> readBeamTable(const std::filesystem::path& file);

// Returns the firing time of each laser (us after the earliest laser). The file is one of Hesai's firetime correction
// files (Channel, fire time in us or ns) or a table with a column firing_time_us. Throws InputError with the line, also
// if a file gives several states of the sensor with different firing times.
std::vector<double> readFiringTable(const std::filesystem::path& file);

extern const FormatSupport kOusterFormat;

struct OusterMetadata {
  std::string model;  // "OS-1-128", or empty if the file does not name the model
  // Angles per ring (deg), in the file's order, without unused lasers; azimuths are counter-clockwise.
  std::vector<double> elevation, azimuth;
  std::uint32_t columns = 0;  // columns per revolution; 0: the file does not state them
  double rate = 0;            // revolutions per second; 0: the file does not state it
  // First column and number of columns of the window that the sensor reports.
  std::uint32_t firstColumn = 0, windowColumns = 0;
  double firstAzimuth = 0;  // deg, azimuth of column 0
  double originOffset = 0;  // m, distance from the axis of rotation to the beam origins
  double originHeight = 0;  // m, height of the beam origins above the origin of the sensor's frame
};

// Reads the metadata of old or new firmware: a complete file, or only the beams' angles and the mode. Missing values
// get the defaults of Ouster's own software (ouster-sdk, types.cpp). Throws InputError with the file and the reason.
OusterMetadata readOusterMetadata(const std::filesystem::path& file);

}  // namespace scanmill
