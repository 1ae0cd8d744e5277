#pragma once

// Reads meshes of OBJ, STL and PLY, and by the assimp library COLLADA and AC3D. The library is made for trusted files.
// Therefore it runs in a child process, which may crash or exceed its time or memory without harm to this process.

#include <filesystem>
#include <string>

#include "assets/meshes/asset_data.h"

namespace scanmill {

// Reads the file as readAsset() does, but also accepts a file without triangles. `kind` is its extension in lower case.
Asset readImported(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options);

}  // namespace scanmill
