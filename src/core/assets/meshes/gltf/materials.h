#pragma once

// The materials of a glTF file (glTF 2.0, 3.9).

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "assets/meshes/asset_data.h"
#include "assets/meshes/gltf/data.h"
#include "assets/meshes/gltf/model.h"

namespace scanmill::gltf {

struct ReadMaterial {
  scanmill::Material material;
  std::array<float, 3> color{1, 1, 1};  // base colour, see AssetPart::color
  std::string texture;                  // name of the texture, see AssetPart::texture
  std::optional<TextureUse> placed;     // how the base colour uses its texture
  LeftOut leftOut;                      // what the material has and is not modelled
};

// Returns the materials in the file's order, and after them the default material of primitives without a material.
// Warns of missing and broken textures.
std::vector<ReadMaterial> readMaterials(const Model& model, const Data& data, const AssetOptions& options);

}  // namespace scanmill::gltf
