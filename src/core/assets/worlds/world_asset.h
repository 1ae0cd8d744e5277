#pragma once

// World descriptions as assets: an object of a scene can name a world description like any other 3D file.

#include <filesystem>
#include <string_view>

#include "assets/asset.h"
#include "base/format_support.h"

namespace scanmill {

// Reads a world description with all files that it names. For 3D Tiles see readTileset(). In SDF and URDF each model
// has one node index; its parts are named "model/link/visual" or, if a mesh has nodes, "model/link/visual/node". If a
// model is included several times under names that differ only in the numbers at their ends, the copies share their
// meshes (Asset::instanced), and their common name lacks the number. A model with visuals is one thing, together with
// all models nested in it. A model without visuals is not a thing, but the models nested in it are: a single one has
// the name of the model around it, several are called "model/nested". Throws InputError with the place in the file, for
// example with all models and meshes that are missing unless AssetOptions::leaveOutMissing is set, and warns of
// contents that are left out.
Asset readWorld(const std::filesystem::path& file, std::string_view suffix, const AssetOptions& options);

// Returns what the reader of 3D Tiles reads and leaves out.
const FormatSupport& tilesetFormat();

// Reads 3D Tiles 1.0 and 1.1 (OGC 22-025r4): the finest tiles that a tileset.json names, and coarser tiles whose
// refinement is ADD, with transforms, relative centres and nested tilesets. Contents can be glTF, GLB and b3dm; other
// contents are left out, with a warning. If the tileset is on the earth, the asset's origin is the middle of the root
// tile, or if this is not on the earth's surface, of the first tile whose middle is, with x east, y north and z up. A
// node's name begins with the content's path relative to the tileset and a slash. Throws an InputError that names the
// file.
Asset readTileset(const std::filesystem::path& file, const AssetOptions& options);

}  // namespace scanmill
