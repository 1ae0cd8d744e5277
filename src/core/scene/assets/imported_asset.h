#pragma once

// Reads the kinds of files that the assimp library knows.

#include <filesystem>
#include <string>

#include "scene/assets/asset.h"

namespace scanmill {

// Reads the file as readAsset() does, but that it may have no triangle. `kind` is its ending in lower case, ".obj".
Asset readImported(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options);

}  // namespace scanmill
