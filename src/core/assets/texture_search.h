#pragma once

// Finds the images that assets name.

#include <filesystem>
#include <string>

namespace scanmill {

// Finds the file that the asset at `asset` calls `name`; empty where there is none. The name is taken relative to the
// asset, then as an address that begins with model:// or file://. Then a file of that name without its folders is
// looked for in the asset's folder and in the folders beside it that usually hold textures, and at last all of that
// without regard to upper and lower case. A name that leads out of the asset's folder is an InputError where there is
// such a file and nowhere else, unless `allowOutside`, where it counts like any other.
std::filesystem::path findTexture(const std::filesystem::path& asset, const std::string& name, bool allowOutside);

}  // namespace scanmill
