#pragma once

// Worlds as assets: an object of a scene names one like any other 3D file.

#include <filesystem>
#include <string_view>

#include "assets/asset.h"

namespace scanmill {

// Whether files of this suffix (".sdf", lower case) describe worlds.
bool isWorld(std::string_view suffix);

// Reads a description with all that it names; of 3D Tiles see tileset.h. In SDF and URDF each model is a node, called
// "model/link/visual" or, where its mesh has nodes, "model/link/visual/node". Models that are included several times,
// under names that differ in the numbers at their ends alone, share their meshes (Asset::instanced) and the name
// without its numbers. A model is one thing with all that is nested in it, unless it has no visuals of its own. Throws
// InputError with the place, and warns of what is left out.
Asset readWorld(const std::filesystem::path& file, std::string_view suffix, const AssetOptions& options);

}  // namespace scanmill
