#pragma once

// The materials of an asset, translated from the importer's terms.

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "scene/assets/asset.h"

struct aiScene;

namespace scanmill {

struct AssetMaterial {
  Material material;
  std::array<float, 3> color{1, 1, 1};  // AssetPart::color
  std::string texture;                  // base colour file as the asset names it, or empty
  unsigned uvChannel = 0;               // texture coordinates that the base colour uses
};

// Returns the materials of the imported file. A missing or broken texture is a warning.
std::vector<AssetMaterial> readMaterials(const aiScene& scene, const std::filesystem::path& file,
                                         const AssetOptions& options);

}  // namespace scanmill
