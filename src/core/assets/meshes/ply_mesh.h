#pragma once

#include <filesystem>
#include <optional>

#include "assets/meshes/asset_data.h"
#include "assets/meshes/imported_file.h"

namespace scanmill {

// Reads a PLY file of the kind that scans and reconstructions produce: little-endian vertices and triangles without
// texture coordinates. Only positions and indices are used. Large coordinates in double keep their precision: see
// ImportedFile::origin. Returns nullopt for all other files, and for damaged ones; the importer must read these,
// several times more slowly. Throws InputError if the header is not valid.
std::optional<ImportedFile> readPlyMesh(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
