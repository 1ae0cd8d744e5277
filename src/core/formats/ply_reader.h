#pragma once

// Reads the points of a PLY file: its element `vertex`, whatever else it has.

#include <filesystem>

#include "formats/cloud_file.h"

namespace scanmill {

// See readCloud() of formats/cloud_file.h for the names of columns. Throws InputError with the file and its line.
Cloud readPly(const std::filesystem::path& file);

}  // namespace scanmill
