#pragma once

// The materials of an asset, translated from the importer's terms.

#include <filesystem>
#include <string>
#include <vector>

#include "scene/assets/asset.h"

struct aiScene;

namespace scanmill {

struct AssetMaterial {
  Material material;
  std::string texture;     // base colour file as the asset names it, or empty
  unsigned uvChannel = 0;  // texture coordinates that the base colour uses
};

// Returns the materials of the imported file. A missing or broken texture is a warning.
std::vector<AssetMaterial> readMaterials(const aiScene& scene, const std::filesystem::path& file, bool gltf,
                                         const AssetOptions& options);

// Finds the file that the asset at `asset` calls `name`; empty where there is none. The name is taken relative to the
// asset, then as an address that begins with model:// or file://. Then a file of that name without its folders is
// looked for in the asset's folder and in the folders beside it that usually hold textures, and at last all of that
// without regard to upper and lower case.
std::filesystem::path findTexture(const std::filesystem::path& asset, const std::string& name);

}  // namespace scanmill
