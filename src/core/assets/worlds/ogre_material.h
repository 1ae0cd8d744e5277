#pragma once

// Scripts of OGRE materials, by which Gazebo's models name the images of meshes that do not name their own.

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace scanmill {

// What a script says of a material: its first image, its diffuse colour, and below which alpha it is cut out.
struct OgreMaterial {
  std::string texture;  // as the script names it, or empty
  std::optional<std::array<float, 3>> color;
  std::optional<float> alphaCutoff;
};

// The materials of a script, or of all scripts (*.material) of a folder, by their names. Nothing where there are none;
// what is not understood is passed over.
std::map<std::string, OgreMaterial> readOgreMaterials(const std::filesystem::path& place);

}  // namespace scanmill
