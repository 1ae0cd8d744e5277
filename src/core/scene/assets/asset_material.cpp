#include "scene/assets/asset_material.h"

#include <assimp/material.h>
#include <assimp/scene.h>
#include <fmt/core.h>

#include <memory>
#include <utility>

#include "base/error.h"
#include "scene/assets/asset_alpha.h"
#include "scene/assets/base_color.h"
#include "scene/assets/texture.h"

namespace scanmill {

namespace {

// Reads the materials of one file.
class MaterialReader {
 public:
  MaterialReader(const aiScene& scene, const std::filesystem::path& file, const AssetOptions& options)
      : scene_(scene), file_(file), options_(options), images_(file) {}

  AssetMaterial read(unsigned index) {
    const aiMaterial& material = *scene_.mMaterials[index];
    AssetMaterial read;
    read.material.name = text(material, AI_MATKEY_NAME);
    const bool made = read.material.name == AI_DEFAULT_MATERIAL_NAME;
    if (made) read.material.name.clear();
    read.material.source = "base colour of " + file_.filename().string();
    read.material.roughness = fraction(number(material, AI_MATKEY_ROUGHNESS_FACTOR, 1.0f), 1.0f);
    read.material.metallic = fraction(number(material, AI_MATKEY_METALLIC_FACTOR, 0.0f), 0.0f);

    const Map map = firstMap(material, {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE});
    const Map opacity = firstMap(material, {aiTextureType_OPACITY});
    read.texture = map.label;
    read.uvChannel = map.name.empty() ? opacity.uvChannel : map.uvChannel;

    BaseColor color;
    const aiColor4D factor = baseColor(material);
    color.factor = {factor.r, factor.g, factor.b};
    color.stated = !made;
    color.textured = !map.name.empty();
    bool declared = false;
    color.alpha = alphaTest(material, opacity, declared);
    if (color.textured && (options_.textures || color.alpha.wanted)) {
      color.image = load(map, !options_.textures, color.alpha.wanted);
    }
    if (color.image && color.alpha.wanted && !declared &&
        !isCutOut(measureAlpha(scene_, index, read.uvChannel, *color.image))) {
      color.alpha.wanted = false;
      if (!options_.textures) color.image.reset();
    }
    color.colored = color.image != nullptr;
    // What stands beside a texture is what the exporter happened to leave there, often black.
    if (!color.colored) read.color = color.factor;
    // A map that names the colour's own file means that file's alpha, which the image has already.
    if (color.alpha.wanted && !opacity.name.empty() && opacity.name != map.name) {
      if (const auto mask = load(opacity, false, true))
        color.image = withOpacity(color.image.get(), *mask, opacity.inverted);
    }
    setColor(read.material, std::move(color), file_, options_, images_);
    return read;
  }

 private:
  struct Map {
    std::string name;   // as the importer gives it: a file, or "*n" for an embedded one
    std::string label;  // for people and rules
    unsigned uvChannel = 0;
    bool inverted = false;
  };

  static std::string text(const aiMaterial& material, const char* key, unsigned type, unsigned i) {
    aiString value;
    return material.Get(key, type, i, value) == aiReturn_SUCCESS ? std::string(value.C_Str()) : std::string();
  }

  static float number(const aiMaterial& material, const char* key, unsigned type, unsigned i, float fallback) {
    float value = 0;
    return material.Get(key, type, i, value) == aiReturn_SUCCESS ? value : fallback;
  }

  Map firstMap(const aiMaterial& material, std::initializer_list<aiTextureType> types) const {
    for (const aiTextureType type : types) {
      Map map;
      map.name = text(material, AI_MATKEY_TEXTURE(type, 0));
      if (map.name.empty()) continue;
      int channel = 0;
      if (material.Get(AI_MATKEY_UVWSRC(type, 0), channel) == aiReturn_SUCCESS && channel >= 0) {
        map.uvChannel = static_cast<unsigned>(channel);
      }
      int flags = 0;
      if (material.Get(AI_MATKEY_TEXFLAGS(type, 0), flags) == aiReturn_SUCCESS) {
        map.inverted = (flags & aiTextureFlags_Invert) != 0;
      }
      const aiTexture* embedded = scene_.GetEmbeddedTexture(map.name.c_str());
      map.label = embedded != nullptr && embedded->mFilename.length > 0 ? embedded->mFilename.C_Str() : map.name;
      return map;
    }
    return {};
  }

  // Linear, which is what most exporters write.
  static aiColor4D baseColor(const aiMaterial& material) {
    aiColor4D color(1, 1, 1, 1);
    if (material.Get(AI_MATKEY_COLOR_DIFFUSE, color) != aiReturn_SUCCESS) material.Get(AI_MATKEY_BASE_COLOR, color);
    return {fraction(color.r, 1.0f), fraction(color.g, 1.0f), fraction(color.b, 1.0f), fraction(color.a, 1.0f)};
  }

  // It is declared where beams pass whatever the alpha looks like.
  AlphaTest alphaTest(const aiMaterial& material, const Map& opacityMap, bool& declared) const {
    if (options_.alpha == AlphaUse::Ignore) return {};
    // 0 would hide the material: it comes from exporters that take the number for the opposite.
    const float opacity = number(material, AI_MATKEY_OPACITY, 1.0f);
    declared = options_.alpha == AlphaUse::Test || !opacityMap.name.empty() || (opacity > 0 && opacity < 1);
    return {true, 0.5f};
  }

  std::shared_ptr<const Texture> load(const Map& map, bool onlyAlpha, bool cutsOut) {
    return images_.load(map.name, map.label, onlyAlpha, cutsOut, [&]() -> std::shared_ptr<const Texture> {
      const aiTexture* const embedded = scene_.GetEmbeddedTexture(map.name.c_str());
      return embedded == nullptr ? nullptr : decodeEmbedded(*embedded, file_.string() + ": " + map.label);
    });
  }

  static std::shared_ptr<const Texture> decodeEmbedded(const aiTexture& embedded, const std::string& name) {
    if (embedded.mHeight == 0) {
      return decodeTexture({reinterpret_cast<const char*>(embedded.pcData), embedded.mWidth}, name);
    }
    if (embedded.mWidth == 0 || embedded.mWidth > 16384 || embedded.mHeight > 16384) {
      throw InputError({name}, "the embedded image has no usable size");
    }
    auto texture = std::make_shared<Texture>();
    texture->file = name;
    texture->width = embedded.mWidth;
    texture->height = embedded.mHeight;
    texture->rgba.reserve(std::size_t{embedded.mWidth} * embedded.mHeight * 4);
    for (unsigned row = embedded.mHeight; row-- > 0;) {
      for (unsigned column = 0; column < embedded.mWidth; ++column) {
        const aiTexel& texel = embedded.pcData[std::size_t{row} * embedded.mWidth + column];
        texture->rgba.insert(texture->rgba.end(), {texel.r, texel.g, texel.b, texel.a});
        texture->hasAlpha = texture->hasAlpha || texel.a < 255;
      }
    }
    return texture;
  }

  const aiScene& scene_;
  const std::filesystem::path& file_;
  const AssetOptions& options_;
  ColorImages images_;
};

}  // namespace

std::vector<AssetMaterial> readMaterials(const aiScene& scene, const std::filesystem::path& file,
                                         const AssetOptions& options) {
  MaterialReader reader(scene, file, options);
  std::vector<AssetMaterial> materials;
  for (unsigned i = 0; i < scene.mNumMaterials; ++i) materials.push_back(reader.read(i));
  return materials;
}

}  // namespace scanmill
