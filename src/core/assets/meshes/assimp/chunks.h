#pragma once

// Searches files that consist of chunks (3DS, LWO) for facts that the assimp library does not report.

#include <filesystem>
#include <string>

#include "base/format_support.h"

namespace scanmill {

// Returns the bytes of a .3ds file without the meshes of hidden objects, which are counted. A master scale, by which
// assimp divides all lengths, is named.
std::string read3ds(const std::filesystem::path& file, LeftOut& leftOut);

// Returns the bytes of a .lwo file without the polygons of hidden layers (LWO2), which are counted.
std::string readLwo(const std::filesystem::path& file, LeftOut& leftOut);

}  // namespace scanmill
