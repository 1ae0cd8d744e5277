#pragma once

// Reads files with the assimp library. Damaged files can crash it, or make it use much time and memory: see
// readImported() in assets/imported_asset.h.

#include <filesystem>
#include <string>

#include "assets/asset.h"
#include "assets/imported_file.h"

namespace scanmill {

// Reads a file. `kind` is its extension in lower case, such as ".obj". Throws Error with the problem, but without the
// file's name.
ImportedFile readByAssimp(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options);

}  // namespace scanmill
