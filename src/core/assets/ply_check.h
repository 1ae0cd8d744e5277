#pragma once

#include <filesystem>

#include "formats/ply_header.h"

namespace scanmill {

// Checks that a PLY file holds what its header announces. Without this, the importer would loop for ever on a header
// that ends early, believe every count, and invent what was cut off. Throws an InputError that names the file and what
// is wrong. Returns the header.
PlyHeader checkPly(const std::filesystem::path& file);

}  // namespace scanmill
