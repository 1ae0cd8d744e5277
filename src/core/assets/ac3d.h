#pragma once

#include <filesystem>
#include <string>

namespace scanmill {

// Returns the text of an AC3D file with at most one texture per object, as assimp requires. Racing games write several
// textures per object. The texture with the role `base`, or else the first texture, is the colour and is kept; the
// others are shading and skid marks.
std::string readAc3d(const std::filesystem::path& file);

}  // namespace scanmill
