#pragma once

// 3D Tiles 1.0 and 1.1 (OGC 22-025r4): a tileset.json with the tiles that it names.

#include <filesystem>

#include "assets/asset.h"

namespace scanmill {

// Reads the finest tiles of a tileset, and coarser tiles whose refinement is ADD, with transforms, relative centres and
// nested tilesets. Contents can be glTF, GLB and b3dm; other contents are left out, with a warning. If the tileset is
// on the earth, the asset's origin is the middle of the root tile, with x east, y north and z up. A node's name begins
// with the content's file and a slash. Throws an InputError that names the file.
Asset readTileset(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
