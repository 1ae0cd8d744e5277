#pragma once

#include <filesystem>

#include "config/value.h"

namespace scanmill {

// Prints what `scanmill info` shows of a sensor's file.
void printSensor(const Value& sensor);

// True if a file is Ouster's metadata or a table of a sensor's lasers, by its suffix and contents.
bool isCalibration(const std::filesystem::path& file);
// Prints what `scanmill info` shows of a calibration of Velodyne, Ouster or Hesai: see sensors/calibration.h.
void printCalibration(const std::filesystem::path& file);

}  // namespace scanmill
