#pragma once

#include <string>
#include <string_view>

#include "scan/scan.h"

namespace scanmill {

// Begins a line in the header of a PCD that this program has written, which is a comment to other readers. The line
// states the sensor's rings and columns and whether the scan is organised or dense.
constexpr std::string_view kPcdSensorComment = "# scanmill sensor:";

// Reads any valid PCD. Fields may be in any order and of any numeric type that holds their values. Fields that the
// table of columns does not have are kept as foreign columns. If there is no `intensity`, it is filled from
// `reflectivity`. Throws an InputError that begins with `what`, the name of the bytes. If `origin` is not null, it
// becomes cloudOrigin() of the first finite point (formats/cloud_file.h), and positions are relative to it.
Scan readPcd(std::string_view bytes, const std::string& what, Vec3d* origin = nullptr);

}  // namespace scanmill
