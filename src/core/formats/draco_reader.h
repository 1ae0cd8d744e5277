#pragma once

#include <string>
#include <string_view>

#include "scan/scan.h"

namespace scanmill {

// Reads any Draco point cloud that has positions. Its other attributes are recognised by their metadata entry "name".
// Throws an InputError that begins with `what`, the name of the bytes.
Scan readDraco(std::string_view bytes, const std::string& what);

}  // namespace scanmill
