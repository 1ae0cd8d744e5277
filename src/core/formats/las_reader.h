#pragma once

// Reads LAS 1.0 to 1.4, point formats 0 to 10: "LAS Specification 1.4 - R15", American Society for Photogrammetry and
// Remote Sensing, 2019.

#include <string>
#include <string_view>

#include "formats/cloud_file.h"

namespace scanmill {

// Reads the points, except points marked as withheld. Coordinates are taken as metres, the unit of nearly all files; a
// unit in the file's coordinate system is ignored. Throws an InputError that begins with `what`, the name of the bytes,
// if they are not LAS, of another version, truncated, or compressed (LAZ).
Cloud readLas(std::string_view bytes, const std::string& what);

}  // namespace scanmill
