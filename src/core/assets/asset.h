#pragma once

// Reads 3D files of all kinds that `scanmill list inputs` lists, with all files that they name.

#include <filesystem>

#include "assets/meshes/asset_data.h"

namespace scanmill {

// Reads the file. Throws an InputError that names the file and the problem, such as a file that is absent, empty,
// truncated, of an unknown kind or without triangles. If a texture is missing, warns and gives its material a plain
// colour. One warning counts all contents of the file that are not read, such as lines and points.
Asset readAsset(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
