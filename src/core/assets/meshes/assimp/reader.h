#pragma once

// Reads files with the assimp library. A damaged file can crash it, or make it use much time and memory; therefore
// readImported() in assets/meshes/imported_asset.h runs it in a child process.

#include <filesystem>
#include <string>

#include "assets/meshes/asset_data.h"
#include "assets/meshes/imported_file.h"
#include "base/format_support.h"

namespace scanmill {

// Returns what is read of all kinds of files that have no table of their own.
const FormatSupport& importedFormat();

// Reads a file. `kind` is its extension in lower case, such as ".dae". Throws an Error that states the problem, but not
// the file's name.
ImportedFile readByAssimp(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options);

}  // namespace scanmill
