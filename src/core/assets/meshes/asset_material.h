#pragma once

// The materials of an imported file, with the images that they name.

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "assets/meshes/asset_data.h"
#include "assets/meshes/imported_file.h"

namespace scanmill {

struct AssetMaterial {
  Material material;
  std::array<float, 3> color{1, 1, 1};  // see AssetPart::color
  std::string texture;                  // base colour file as the asset names it, or empty
};

// Returns the materials of the imported file, in its order. Warns of missing and broken textures. Throws InputError for
// a texture outside of the file's folder, unless AssetOptions::allowOutside is set. Adds what is not modelled to
// `leftOut`.
std::vector<AssetMaterial> readMaterials(const ImportedFile& imported, const std::filesystem::path& file,
                                         const AssetOptions& options, LeftOut& leftOut);

}  // namespace scanmill
