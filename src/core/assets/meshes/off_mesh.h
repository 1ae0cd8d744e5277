#pragma once

// Reads the text files OFF of Geomview (http://www.geomview.org/docs/html/OFF.html), such as those of ModelNet:
//
//   [ST][C][N]OFF
//   VERTICES FACES EDGES      the number of each
//   x y z [normal] [colour] [texture coordinates]      a line for each vertex
//   n v1 ... vn [colour]                               a line for each face, with indices that count from 0

#include <filesystem>

#include "assets/meshes/asset_data.h"
#include "assets/meshes/imported_file.h"
#include "base/format_support.h"

namespace scanmill {

const FormatSupport& offFormat();

// Reads the file. Triangles with indices out of range are dropped and counted. Throws InputError with the line that
// cannot be read.
ImportedFile readOffMesh(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
