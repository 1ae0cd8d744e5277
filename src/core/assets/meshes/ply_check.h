#pragma once

#include <filesystem>

#include "base/format_support.h"
#include "formats/ply_header.h"

namespace scanmill {

// What becomes of the elements and properties of meshes.
const FormatSupport& plyMeshFormat();

// Warns of the elements, and the properties of vertices and faces, from which no surface is made.
void tellLeftOut(const PlyHeader& header, const std::filesystem::path& file);

// Checks that a PLY file contains what its header announces, and returns the header. Without this check, the importer
// would loop for ever on a header that ends early, trust every count, and invent the missing data of a truncated file.
// Warns as tellLeftOut() does. Throws an InputError that names the file and the problem.
PlyHeader checkPly(const std::filesystem::path& file);

}  // namespace scanmill
