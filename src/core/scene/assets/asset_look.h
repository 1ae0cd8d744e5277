#pragma once

// What an asset's materials look like, translated from the importer's terms.

#include <filesystem>
#include <string>
#include <vector>

#include "scene/assets/asset.h"

struct aiScene;

namespace scanmill {

struct AssetLook {
  Material material;
  std::string texture;     // base colour file as the asset names it, or empty
  unsigned uvChannel = 0;  // texture coordinates that the base colour uses
};

// One per material of the imported file. Missing or broken textures are one warning each.
std::vector<AssetLook> readLooks(const aiScene& scene, const std::filesystem::path& file, bool gltf,
                                 const AssetOptions& options);

// The file that an asset at `asset` means by `name`; empty where there is none. Looks at the name relative to the
// asset, at model:// and file:// addresses, then for the bare file name in the asset's folder and in the folders beside
// it that hold textures by custom, case-insensitively at last.
std::filesystem::path findTexture(const std::filesystem::path& asset, const std::string& name);

}  // namespace scanmill
