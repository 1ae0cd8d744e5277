#pragma once

// Searches files that consist of chunks (3DS, LWO) for facts that the assimp library does not report.

#include <filesystem>
#include <string>

#include "base/format_support.h"

namespace scanmill {

// Returns the bytes of a .3ds file without the meshes of hidden objects, which are counted. Objects that the keyframer
// does not place have a node in it, without which assimp leaves them out, or all names if there are no nodes. A master
// scale, by which assimp divides all lengths, is named.
std::string read3ds(const std::filesystem::path& file, LeftOut& leftOut);

// Returns the bytes of a .lwo file without the polygons of hidden layers (LWO2), which are counted, as are polygons
// that assimp does not read as they are. Layers with several chunks of polygons, of which assimp reads the last one,
// are divided into layers of one chunk each.
std::string readLwo(const std::filesystem::path& file, LeftOut& leftOut);

}  // namespace scanmill
