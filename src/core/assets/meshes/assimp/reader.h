#pragma once

// Reads COLLADA and AC3D with the assimp library. A damaged file can crash it, or make it use much time and memory;
// therefore readImported() in assets/meshes/imported_asset.h runs it in a child process.

#include <filesystem>
#include <string>

#include "assets/meshes/asset_data.h"
#include "assets/meshes/imported_file.h"
#include "base/format_support.h"

namespace scanmill {

const FormatSupport& colladaFormat();
const FormatSupport& ac3dFormat();

// Reads a file. `kind` is its extension in lower case: ".dae", or one of AC3D. Throws an Error that states the problem,
// but not the file's name.
ImportedFile readByAssimp(const std::filesystem::path& file, const std::string& kind, const AssetOptions& options);

// Returns advice for messages about a file of this kind that cannot be read.
std::string remedyFor(const std::string& kind);

}  // namespace scanmill
