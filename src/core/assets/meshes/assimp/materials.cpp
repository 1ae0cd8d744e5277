#include <assimp/material.h>
#include <assimp/scene.h>

#include <initializer_list>

#include "assets/meshes/assimp/parts.h"
#include "assets/meshes/base_color.h"

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

// Returns the image of the first of these types that the material has.
ImportedMap firstMap(const aiMaterial& material, std::initializer_list<aiTextureType> types, LeftOut& leftOut) {
  for (const aiTextureType type : types) {
    ImportedMap map;
    map.name = text(material, AI_MATKEY_TEXTURE(type, 0));
    if (map.name.empty()) continue;
    int channel = 0;
    if (material.Get(AI_MATKEY_UVWSRC(type, 0), channel) == aiReturn_SUCCESS && channel >= 0) {
      map.placement.channel = static_cast<std::uint32_t>(channel);
    }
    if (aiUVTransform to; material.Get(AI_MATKEY_UVTRANSFORM(type, 0), to) == aiReturn_SUCCESS) {
      map.placement.scale = {to.mScaling.x, to.mScaling.y};
      map.placement.offset = {to.mTranslation.x, to.mTranslation.y};
      // The importer takes degrees for radians, and no specification states the sign.
      if (to.mRotation != 0) leftOut.add("rotations of images (rotateUV)");
    }
    int flags = 0;
    if (material.Get(AI_MATKEY_TEXFLAGS(type, 0), flags) == aiReturn_SUCCESS) {
      map.inverted = (flags & aiTextureFlags_Invert) != 0;
    }
    for (const auto wrap : {material.Get(AI_MATKEY_MAPPINGMODE_U(type, 0), flags) == aiReturn_SUCCESS ? flags : 0,
                            material.Get(AI_MATKEY_MAPPINGMODE_V(type, 0), flags) == aiReturn_SUCCESS ? flags : 0}) {
      map.repeats = map.repeats && wrap == aiTextureMapMode_Wrap;
    }
    return map;
  }
  return {};
}

}  // namespace

std::vector<ImportedMaterial> materialsOf(const aiScene& scene, LeftOut& leftOut) {
  std::vector<ImportedMaterial> materials;
  for (unsigned i = 0; i < scene.mNumMaterials; ++i) {
    const aiMaterial& from = *scene.mMaterials[i];
    ImportedMaterial& to = materials.emplace_back();
    to.name = text(from, AI_MATKEY_NAME);
    to.stated = to.name != kDefaultMaterial;
    if (!to.stated) to.name.clear();
    to.roughness = fraction(number(from, AI_MATKEY_ROUGHNESS_FACTOR, 1.0f), 1.0f);
    to.metallic = fraction(number(from, AI_MATKEY_METALLIC_FACTOR, 0.0f), 0.0f);
    aiColor4D color(1, 1, 1, 1);
    to.stated = to.stated && from.Get(AI_MATKEY_COLOR_DIFFUSE, color) == aiReturn_SUCCESS;
    to.opacity = number(from, AI_MATKEY_OPACITY, 1.0f);
    to.color = {fraction(color.r, 1.0f), fraction(color.g, 1.0f), fraction(color.b, 1.0f)};
    to.opacityMap = firstMap(from, {aiTextureType_OPACITY}, leftOut);
    to.base = firstMap(from, {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}, leftOut);
  }
  return materials;
}

}  // namespace scanmill
