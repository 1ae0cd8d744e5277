#pragma once

// Reads scripts of OGRE materials, with which Gazebo's models name the images of meshes whose files name none.

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "base/format_support.h"

namespace scanmill {

// Returns what the reader of OGRE materials reads and leaves out.
const FormatSupport& ogreFormat();

// Properties that a script states for a material: its first image, its diffuse colour, and its alpha cutoff.
struct OgreMaterial {
  std::string texture;  // name of the image in the script; empty: none
  std::optional<std::array<float, 3>> color;
  std::optional<float> alphaCutoff;  // beams pass where alpha is below this
  std::string base;                  // name of the material from which it inherits; empty: none
};

// Returns the materials of a script, or of all scripts (*.material) in a folder, by name. Empty if there are none. Adds
// to `leftOut` what their scripts have besides.
std::map<std::string, OgreMaterial> readOgreMaterials(const std::filesystem::path& place, LeftOut& leftOut);

}  // namespace scanmill
