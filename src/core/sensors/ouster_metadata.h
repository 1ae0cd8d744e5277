#pragma once

// The metadata of Ouster's sensors, as they report it and their recordings come with it.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace scanmill {

struct OusterMetadata {
  std::string model;  // "OS-1-128", or empty where the file does not say
  // Per ring, as the file has them, without those of lasers that are not there; degrees, azimuths counter-clockwise.
  std::vector<double> elevation, azimuth;
  std::uint32_t columns = 0;  // a revolution
  double rate = 0;            // revolutions a second
  // Where the window of columns that are reported begins, and how many they are.
  std::uint32_t firstColumn = 0, windowColumns = 0;
  double firstAzimuth = 0;  // deg, of column 0
  double originOffset = 0;  // m, from the axis to where beams start
  double originHeight = 0;  // m
};

// Reads metadata of any firmware, old or new, whole or reduced to the beams' angles and the mode; what it leaves out is
// as Ouster's own software takes it (ouster-sdk, types.cpp). Throws InputError with the file and what is wrong.
OusterMetadata readOusterMetadata(const std::filesystem::path& file);

}  // namespace scanmill
