#pragma once

#include <array>
#include <filesystem>

#include "config/value.h"
#include "sensors/beams.h"

namespace scanmill {

// Returns the horizontal and the vertical field of view of the beams (deg). A horizontal gap of less than 5 degrees
// counts as none.
std::array<double, 2> fieldOf(const BeamTable& beams);
// Prints what `scanmill info` shows of a sensor's file.
void printSensor(const Value& sensor);

// True if a file is Ouster's metadata or a table of a sensor's lasers, by its suffix and contents.
bool isCalibration(const std::filesystem::path& file);
// Prints what `scanmill info` shows of a calibration of Velodyne, Ouster or Hesai: see sensors/calibration.h.
void printCalibration(const std::filesystem::path& file);

// Print what `scanmill info` shows of a recording's folder, and of one EXR image of passes or hits.
void printRecording(const std::filesystem::path& folder);
void printExr(const std::filesystem::path& file);

}  // namespace scanmill
