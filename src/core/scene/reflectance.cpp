#include "scene/reflectance.h"

#include "scene/texture.h"

namespace scanmill {

float CompactMaterial::texturedAt(const Vec2f& uv) const {
  return ofTexel(texture->texel(uv.x, uv.y));
}

float CompactMaterial::ofTexel(const std::uint8_t* texel) const {
  return std::min(1.0f, textureGain * luminance(texel));
}

CompactMaterial compact(const Material& material) {
  CompactMaterial compacted{.reflectance = material.reflectance};
  if (material.textured && material.texture != nullptr && material.textureMean > 0) {
    compacted.texture = material.texture.get();
    compacted.textureGain = material.reflectance / material.textureMean;
  }
  return compacted;
}

std::vector<CompactMaterial> compactMaterials(const Scene& scene) {
  std::vector<CompactMaterial> materials;
  materials.reserve(scene.materials.size());
  for (const Material& material : scene.materials) materials.push_back(compact(material));
  return materials;
}

}  // namespace scanmill
