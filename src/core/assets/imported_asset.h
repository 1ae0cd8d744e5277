#pragma once

// Reads the kinds of files that the assimp library knows. The library is made for trusted files. Therefore it runs in a
// child process, which may crash or run out of time or memory without harm to this one.

#include <filesystem>
#include <string>

#include "assets/asset.h"

namespace scanmill {

// Reads the file as readAsset() does, but accepts a file without triangles. `kind` is its extension in lower case.
Asset readImported(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options);

// Returns advice for messages about a file of this kind that cannot be read.
std::string remedyFor(const std::string& kind);
bool isAc3d(const std::string& kind);

}  // namespace scanmill
