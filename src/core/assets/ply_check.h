#pragma once

#include <filesystem>

#include "formats/ply_header.h"

namespace scanmill {

// Checks that a PLY file contains what its header announces, and returns the header. Without this check, the importer
// would loop for ever on a header that ends early, trust every count, and invent the missing data of a truncated file.
// Throws an InputError that names the file and the problem.
PlyHeader checkPly(const std::filesystem::path& file);

}  // namespace scanmill
