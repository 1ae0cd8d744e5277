#pragma once

// The metadata of Ouster's sensors, as the sensors report it and recordings include it.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace scanmill {

struct OusterMetadata {
  std::string model;  // "OS-1-128", or empty where the file does not say
  // Per ring, in the file's order, without unused lasers; degrees, azimuths counter-clockwise.
  std::vector<double> elevation, azimuth;
  std::uint32_t columns = 0;  // per revolution
  double rate = 0;            // revolutions per second
  // The window of columns that are reported: its first column and its number of columns.
  std::uint32_t firstColumn = 0, windowColumns = 0;
  double firstAzimuth = 0;  // deg, of column 0
  double originOffset = 0;  // m, from the axis to the beam origins
  double originHeight = 0;  // m
};

// Reads metadata of old and new firmware, complete or reduced to the beams' angles and the mode. Missing values get the
// defaults of Ouster's own software (ouster-sdk, types.cpp). Throws InputError with the file and what is wrong.
OusterMetadata readOusterMetadata(const std::filesystem::path& file);

}  // namespace scanmill
