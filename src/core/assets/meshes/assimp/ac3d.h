#pragma once

#include <filesystem>
#include <string>

#include "base/format_support.h"

namespace scanmill {

const FormatSupport& ac3dFormat();

// Returns the text of an AC3D file (AC3Db or AC3Dc) as assimp reads it, and counts what is left out:
// - at most one texture per object. Racing games write several. The texture with the role `base`, or else the first
//   texture, is the colour and is kept; the others are shading and skid marks;
// - materials in one line each (MATERIAL) in place of blocks (MAT to ENDMAT);
// - hidden objects and those below them without vertices and surfaces;
// - the transform of an object (`rot`, `loc`) in a group around the object and its kids, because assimp shifts surfaces
//   before it rotates them, and does not shift kids.
std::string readAc3d(const std::filesystem::path& file, LeftOut& leftOut);

}  // namespace scanmill
