#pragma once

// The materials of a glTF file (glTF 2.0, 3.9).

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "assets/asset.h"
#include "assets/gltf/data.h"
#include "assets/gltf/model.h"

namespace scanmill::gltf {

struct ReadMaterial {
  scanmill::Material material;
  std::array<float, 3> color{1, 1, 1};  // AssetPart::color
  std::string texture;                  // AssetPart::texture
  std::optional<TextureUse> placed;     // of the base colour's texture
};

// Returns the materials of the file in the file's order, and as the last one the material of primitives that have none.
// A missing or broken texture is a warning.
std::vector<ReadMaterial> readMaterials(const Model& model, const Data& data, const AssetOptions& options);

}  // namespace scanmill::gltf
