#pragma once

// The materials of a glTF file (glTF 2.0, 3.9).

#include <optional>
#include <vector>

#include "assets/meshes/asset_data.h"
#include "assets/meshes/gltf/data.h"
#include "assets/meshes/gltf/model.h"

namespace scanmill::gltf {

struct ReadMaterial : Look {
  std::optional<TextureUse> placed;  // how the base colour uses its texture
  LeftOut leftOut;                   // what the material has and is not modelled
};

// Returns the materials in the file's order, and after them the default material of primitives without a material.
// Warns of missing and broken textures.
std::vector<ReadMaterial> readMaterials(const Model& model, const Data& data, const AssetOptions& options);

}  // namespace scanmill::gltf
