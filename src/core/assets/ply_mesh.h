#pragma once

#include <filesystem>
#include <optional>

#include "assets/asset.h"
#include "assets/imported_file.h"

namespace scanmill {

// Reads a PLY file that holds what scans and reconstructions are made of: little-endian vertices and triangles, of
// whose properties the position and the indices are taken, without texture coordinates. Coordinates in double lose
// nothing where they are large: see ImportedFile::origin. Nothing for any other file, also for a damaged one: that is
// the importer's, which is several times slower. Throws InputError where the header is none.
std::optional<ImportedFile> readPlyMesh(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
