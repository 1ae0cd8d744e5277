#pragma once

#include <string>
#include <string_view>

#include "scan/scan.h"

namespace scanmill {

// The start of a comment in the header of PCDs that this program has written. The line states the sensor's numbers of
// rings and columns, and whether the scan is organised or dense. Other readers ignore it.
constexpr std::string_view kPcdSensorComment = "# scanmill sensor:";

// Reads any valid PCD. Fields may be in any order and of any numeric type whose values fit the column. Fields that are
// not in the table of columns become foreign columns. If there is no field `intensity`, that column is read from
// `reflectivity`. Throws an InputError that begins with `what`, the name of the bytes. If `origin` is not null, it is
// set to cloudOrigin() of the first finite point (formats/cloud_file.h), and positions are relative to it.
Scan readPcd(std::string_view bytes, const std::string& what, Vec3d* origin = nullptr);

}  // namespace scanmill
