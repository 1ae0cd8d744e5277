#pragma once

// Reads the kinds of files that the assimp library knows. Damaged files may crash it or take its time and memory: see
// readImported() in assets/imported_asset.h.

#include <filesystem>
#include <string>

#include "assets/asset.h"
#include "assets/imported_file.h"

namespace scanmill {

// `kind` is the file's ending in lower case, ".obj". Throws Error that says what is wrong, without the file's name.
ImportedFile readByAssimp(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options);

}  // namespace scanmill
