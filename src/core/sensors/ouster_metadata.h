#pragma once

// The metadata of Ouster's sensors, as sensors report them and recordings include them.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace scanmill {

struct FormatSupport;
const FormatSupport& ousterFormat();

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

// Reads metadata of old or new firmware, complete or reduced to the beams' angles and the mode. Missing values get the
// defaults of Ouster's own software (ouster-sdk, types.cpp). Throws InputError with the file and the reason.
OusterMetadata readOusterMetadata(const std::filesystem::path& file);

}  // namespace scanmill
