#pragma once

// Searches .3ds files (3D Studio) for facts that the assimp library does not report.

#include <filesystem>
#include <string>

#include "base/format_support.h"

namespace scanmill {

// Returns the bytes of a .3ds file without the meshes of hidden objects, which are counted. Objects that the keyframer
// does not place have a node in it, without which assimp leaves them out, or all names if there are no nodes. A master
// scale, by which assimp divides all lengths, is named.
std::string read3ds(const std::filesystem::path& file, LeftOut& leftOut);

}  // namespace scanmill
