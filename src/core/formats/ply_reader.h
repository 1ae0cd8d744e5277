#pragma once

// Reads the points of a PLY file, its element `vertex`.

#include <filesystem>

#include "formats/cloud_file.h"

namespace scanmill {

// Reads the vertices as points. For the names of columns see readCloud() in formats/cloud_file.h. Throws an InputError
// with the file and line.
Cloud readPly(const std::filesystem::path& file);

}  // namespace scanmill
