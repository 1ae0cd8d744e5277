#pragma once

#include <string>
#include <string_view>

#include "scan/scan.h"

namespace scanmill {

// Line of an own PCD's header, a comment to other readers: the sensor's rings and columns, organised or dense.
constexpr std::string_view kPcdSensorComment = "# scanmill sensor:";

// Any valid PCD: fields in any order, of any numeric type that holds their values. Fields that the table of columns
// does not have are kept as foreign columns. Where there is no `intensity`, `reflectivity` is taken for it too.
Scan readPcd(std::string_view bytes, const std::string& what);

}  // namespace scanmill
