#pragma once

// Reads LAS 1.0 to 1.4, point formats 0 to 10: "LAS Specification 1.4 - R15", American Society for Photogrammetry and
// Remote Sensing, 2019.

#include <string>
#include <string_view>

#include "formats/cloud_file.h"

namespace scanmill {

// Points that are withheld are left out. Coordinates are metres, as nearly all files have them; the units that a file
// may state in its coordinate system are not read. Throws InputError that begins with `what`, the name of the bytes:
// not LAS, of another version, truncated, or compressed (LAZ).
Cloud readLas(std::string_view bytes, const std::string& what);

}  // namespace scanmill
