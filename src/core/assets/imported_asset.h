#pragma once

// Reads the kinds of files that the assimp library knows. It is made for files of friends: it runs in a child process,
// which may crash or ask for more time and memory than it gets.

#include <filesystem>
#include <string>

#include "assets/asset.h"

namespace scanmill {

// Reads the file as readAsset() does, but that it may have no triangle. `kind` is its ending in lower case, ".obj".
Asset readImported(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options);

// What to do about a file of this kind that cannot be read.
std::string remedyFor(const std::string& kind);
bool isAc3d(const std::string& kind);

}  // namespace scanmill
