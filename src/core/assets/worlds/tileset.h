#pragma once

// 3D Tiles 1.0 and 1.1 (OGC 22-025r4): a tileset.json with the tiles that it names.

#include <filesystem>

#include "assets/asset.h"

namespace scanmill {

// The finest tiles (and coarser ones whose children add to them) with their transforms, relative centres and tilesets
// within tilesets: contents in glTF, GLB and b3dm; what else there is is left out, with a warning. Of a tileset on the
// earth, x is east, y north and z up about the middle of its root. Nodes are called by the content's file, a slash, and
// the node. Throws InputError with the file.
Asset readTileset(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
