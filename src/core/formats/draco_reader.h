#pragma once

#include <string>
#include <string_view>

#include "scan/scan.h"

namespace scanmill {

// Any Draco point cloud with positions. Further columns are recognised by their metadata entry "name".
Scan readDraco(std::string_view bytes, const std::string& what);

}  // namespace scanmill
