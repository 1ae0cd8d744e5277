#pragma once

// Reads meshes of OBJ, STL, PLY and OFF, and by the assimp library DAE, FBX, AC3D, 3DS and X. The library is made
// for trusted files. Therefore it runs in a child process, which may crash or exceed its time or memory without harm to
// this process.

#include <filesystem>
#include <string>

#include "assets/meshes/asset_data.h"

namespace scanmill {

// Reads the file as readAsset() does, but also accepts a file without triangles. `kind` is its extension in lower case.
Asset readImported(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options);

// Returns advice for messages about a file of this kind that cannot be read.
std::string remedyFor(const std::string& kind);
bool isAc3d(const std::string& kind);

}  // namespace scanmill
