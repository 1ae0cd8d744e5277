#pragma once

#include <filesystem>
#include <string>

namespace scanmill {

// The text of an AC3D file with one texture an object, as the importer wants it: racing games write several, of which
// `base` is the colour, or else the first, and the others are shades and skid marks.
std::string readAc3d(const std::filesystem::path& file);

}  // namespace scanmill
