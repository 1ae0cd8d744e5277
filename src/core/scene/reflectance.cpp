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
  CompactMaterial made{material.reflectance, 0, nullptr};
  if (material.textured && material.texture != nullptr && material.textureMean > 0) {
    made.texture = material.texture.get();
    made.textureGain = material.reflectance / material.textureMean;
  }
  return made;
}

std::vector<CompactMaterial> compactMaterials(const Scene& scene) {
  std::vector<CompactMaterial> made;
  made.reserve(scene.materials.size());
  for (const Material& material : scene.materials) made.push_back(compact(material));
  return made;
}

}  // namespace scanmill
