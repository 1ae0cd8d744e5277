#include <assimp/material.h>
#include <assimp/scene.h>

#include <cmath>
#include <cstring>
#include <initializer_list>

#include "assets/meshes/assimp/parts.h"
#include "assets/meshes/base_color.h"
#include "base/error.h"

namespace scanmill {

namespace {

std::string text(const aiMaterial& material, const char* key, unsigned type, unsigned i) {
  aiString value;
  return material.Get(key, type, i, value) == aiReturn_SUCCESS ? std::string(value.C_Str()) : std::string();
}

float number(const aiMaterial& material, const char* key, unsigned type, unsigned i, float fallback) {
  float value = 0;
  return material.Get(key, type, i, value) == aiReturn_SUCCESS ? value : fallback;
}

ImportedMap firstMap(const aiScene& scene, const aiMaterial& material, std::initializer_list<aiTextureType> types,
                     UvPlacement& placement) {
  for (const aiTextureType type : types) {
    ImportedMap map;
    map.name = text(material, AI_MATKEY_TEXTURE(type, 0));
    if (map.name.empty()) continue;
    int channel = 0;
    if (material.Get(AI_MATKEY_UVWSRC(type, 0), channel) == aiReturn_SUCCESS && channel >= 0) {
      placement.channel = static_cast<std::uint32_t>(channel);
    }
    if (aiUVTransform to; material.Get(AI_MATKEY_UVTRANSFORM(type, 0), to) == aiReturn_SUCCESS) {
      placement.scale = {to.mScaling.x, to.mScaling.y};
      placement.offset = {to.mTranslation.x, to.mTranslation.y};
      placement.rotation = to.mRotation;
    }
    int flags = 0;
    if (material.Get(AI_MATKEY_TEXFLAGS(type, 0), flags) == aiReturn_SUCCESS) {
      map.inverted = (flags & aiTextureFlags_Invert) != 0;
    }
    for (const auto wrap : {material.Get(AI_MATKEY_MAPPINGMODE_U(type, 0), flags) == aiReturn_SUCCESS ? flags : 0,
                            material.Get(AI_MATKEY_MAPPINGMODE_V(type, 0), flags) == aiReturn_SUCCESS ? flags : 0}) {
      map.repeats = map.repeats && wrap == aiTextureMapMode_Wrap;
    }
    const auto [embedded, index] = scene.GetEmbeddedTextureAndIndex(map.name.c_str());
    if (embedded != nullptr) map.embedded = index;
    map.label = embedded != nullptr && embedded->mFilename.length > 0 ? embedded->mFilename.C_Str() : map.name;
    return map;
  }
  return {};
}

}  // namespace

Vec2f UvPlacement::apply(const Vec2f& uv) const {
  const float u = uv.x * scale.x - 0.5f;
  const float v = uv.y * scale.y - 0.5f;
  const float c = std::cos(rotation);
  const float s = std::sin(rotation);
  if (rotation == 0) return {uv.x * scale.x + offset.x, uv.y * scale.y + offset.y};
  return {c * u - s * v + 0.5f + offset.x, s * u + c * v + 0.5f + offset.y};
}

std::vector<ImportedMaterial> materialsOf(const aiScene& scene, bool alphaIsOpacity,
                                          std::vector<UvPlacement>& placements) {
  std::vector<ImportedMaterial> materials;
  for (unsigned i = 0; i < scene.mNumMaterials; ++i) {
    const aiMaterial& from = *scene.mMaterials[i];
    ImportedMaterial& to = materials.emplace_back();
    to.name = text(from, AI_MATKEY_NAME);
    to.stated = to.name != AI_DEFAULT_MATERIAL_NAME;
    if (!to.stated) to.name.clear();
    to.roughness = fraction(number(from, AI_MATKEY_ROUGHNESS_FACTOR, 1.0f), 1.0f);
    to.metallic = fraction(number(from, AI_MATKEY_METALLIC_FACTOR, 0.0f), 0.0f);
    aiColor4D color(1, 1, 1, 1);
    const bool colored = from.Get(AI_MATKEY_COLOR_DIFFUSE, color) == aiReturn_SUCCESS ||
                         from.Get(AI_MATKEY_BASE_COLOR, color) == aiReturn_SUCCESS;
    to.stated = to.stated && colored;
    to.opacity = number(from, AI_MATKEY_OPACITY, alphaIsOpacity ? color.a : 1.0f);
    to.color = {fraction(color.r, 1.0f), fraction(color.g, 1.0f), fraction(color.b, 1.0f)};
    UvPlacement placement;
    to.opacityMap = firstMap(scene, from, {aiTextureType_OPACITY}, placement);
    UvPlacement own;
    to.base = firstMap(scene, from, {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}, own);
    placements.push_back(to.base.name.empty() ? placement : own);
  }
  return materials;
}

std::vector<ImportedImage> imagesOf(const aiScene& scene) {
  std::vector<ImportedImage> images;
  for (unsigned i = 0; i < scene.mNumTextures; ++i) {
    const aiTexture& from = *scene.mTextures[i];
    ImportedImage& to = images.emplace_back();
    if (from.mHeight == 0) {  // an image file of mWidth bytes
      to.bytes.assign(reinterpret_cast<const char*>(from.pcData), from.mWidth);
      continue;
    }
    to.width = from.mWidth;
    to.height = from.mHeight;
    if (to.width == 0 || to.width > 16384 || to.height > 16384) throw Error("embeds an image that has no usable size");
    const std::size_t pixels = std::size_t{to.width} * to.height;
    to.bytes.reserve(pixels * 4);
    for (std::size_t p = 0; p < pixels; ++p) {
      const aiTexel& texel = from.pcData[p];
      for (const unsigned char c : {texel.r, texel.g, texel.b, texel.a}) to.bytes += static_cast<char>(c);
    }
  }
  return images;
}

}  // namespace scanmill
