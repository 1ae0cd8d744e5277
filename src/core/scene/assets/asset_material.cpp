#include "scene/assets/asset_material.h"

#include <assimp/GltfMaterial.h>
#include <assimp/material.h>
#include <assimp/scene.h>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "base/error.h"
#include "images/images.h"
#include "scene/assets/asset_alpha.h"
#include "scene/assets/gltf.h"
#include "scene/assets/texture.h"

namespace scanmill {

namespace {

bool isFile(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error);
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

float fraction(float value, float fallback) {
  return std::isfinite(value) ? std::clamp(value, 0.0f, 1.0f) : fallback;
}

// Reads the materials of one file.
class MaterialReader {
 public:
  MaterialReader(const aiScene& scene, const std::filesystem::path& file, bool gltf, const AssetOptions& options)
      : scene_(scene), file_(file), gltf_(gltf), options_(options) {}

  AssetMaterial read(unsigned index) const {
    const aiMaterial& material = *scene_.mMaterials[index];
    AssetMaterial read;
    read.material.name = text(material, AI_MATKEY_NAME);
    const bool made = read.material.name == AI_DEFAULT_MATERIAL_NAME || &material == gltfDefault();
    if (made) read.material.name.clear();
    read.material.source = "base colour of " + file_.filename().string();
    read.material.roughness = fraction(number(material, AI_MATKEY_ROUGHNESS_FACTOR, 1.0f), 1.0f);
    read.material.metallic = fraction(number(material, AI_MATKEY_METALLIC_FACTOR, 0.0f), 0.0f);

    const Map color = firstMap(material, {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE});
    const Map opacity = gltf_ ? Map{} : firstMap(material, {aiTextureType_OPACITY});
    read.texture = color.label;
    read.uvChannel = color.name.empty() ? opacity.uvChannel : color.uvChannel;

    const aiColor4D factor = baseColor(material);
    Alpha alpha = alphaRule(material, factor, opacity);
    std::shared_ptr<const Texture> image;
    if (!color.name.empty() && (options_.textures || alpha.wanted)) image = load(color, !options_.textures);
    if (image && alpha.wanted && !alpha.declared && !isCutOut(measureAlpha(scene_, index, read.uvChannel, *image))) {
      alpha.wanted = false;
      if (!options_.textures) image.reset();
    }
    const bool colored = image != nullptr;
    // A map that names the colour's own file means that file's alpha, which the image has already.
    if (alpha.wanted && !opacity.name.empty() && opacity.name != color.name) {
      if (const auto map = load(opacity, false)) image = withOpacity(image.get(), *map, opacity.inverted);
    }
    finish(read.material, factor, alpha, std::move(image), colored);
    // White beside a texture that is not there is no colour of its own, nor is what the importer makes up.
    const bool untold = !colored && !color.name.empty() && factor.r == 1 && factor.g == 1 && factor.b == 1;
    if (untold || (made && color.name.empty())) {
      const Material fallback;
      read.material.reflectance = fallback.reflectance;
      read.material.metallic = fallback.metallic;
      read.material.source = "default: " + file_.filename().string() + " states no colour";
    }
    return read;
  }

 private:
  struct Map {
    std::string name;   // as the importer gives it: a file, or "*n" for an embedded one
    std::string label;  // for people and rules
    unsigned uvChannel = 0;
    bool inverted = false;
  };

  struct Alpha {
    bool wanted = false;   // the texture's alpha is honoured,
    bool declared = true;  // whatever it looks like
    float cutoff = 0.5f;
  };

  // The material that the importer puts last, for glTF primitives without one.
  const aiMaterial* gltfDefault() const {
    return gltf_ && scene_.mNumMaterials > 0 ? scene_.mMaterials[scene_.mNumMaterials - 1] : nullptr;
  }

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

  // Linear; glTF says so, and for the other kinds it is what most exporters write.
  aiColor4D baseColor(const aiMaterial& material) const {
    aiColor4D color(1, 1, 1, 1);
    if (material.Get(AI_MATKEY_COLOR_DIFFUSE, color) != aiReturn_SUCCESS) material.Get(AI_MATKEY_BASE_COLOR, color);
    return {fraction(color.r, 1), fraction(color.g, 1), fraction(color.b, 1), fraction(color.a, 1)};
  }

  Alpha alphaRule(const aiMaterial& material, const aiColor4D& factor, const Map& opacityMap) const {
    if (options_.alpha == AlphaUse::Ignore) return {};
    const bool asked = options_.alpha == AlphaUse::Test;
    if (!gltf_) {
      // 0 would hide the material: it comes from exporters that take the number for the opposite.
      const float opacity = number(material, AI_MATKEY_OPACITY, 1.0f);
      return {true, asked || !opacityMap.name.empty() || (opacity > 0 && opacity < 1), 0.5f};
    }
    const std::string mode = text(material, AI_MATKEY_GLTF_ALPHAMODE);
    if (mode != "MASK") return {asked || mode == "BLEND", true, 0.5f};
    // The factor's alpha multiplies the texture's before the comparison.
    const float cutoff = number(material, AI_MATKEY_GLTF_ALPHACUTOFF, 0.5f);
    return {true, true, factor.a > 0 && std::isfinite(cutoff) ? cutoff / factor.a : 1.0f};
  }

  // Null, with a warning, where the image is missing or broken; null where only alpha is wanted and there is none.
  std::shared_ptr<const Texture> load(const Map& map, bool onlyAlpha) const {
    try {
      std::shared_ptr<const Texture> texture;
      if (const aiTexture* embedded = scene_.GetEmbeddedTexture(map.name.c_str())) {
        texture = decodeEmbedded(*embedded, file_.string() + ": " + map.label);
      } else {
        const std::filesystem::path path = findTexture(file_, map.name);
        if (path.empty()) {
          warn(fmt::format("{}: the texture '{}' is missing; its material keeps its plain colour", file_.string(),
                           map.name));
          return nullptr;
        }
        if (onlyAlpha && !mayHaveAlpha(path)) return nullptr;
        texture = loadTexture(path);
      }
      return onlyAlpha && !texture->hasAlpha ? nullptr : texture;
    } catch (const InputError& e) {
      warn(fmt::format("{}: the texture '{}' is not used: {}", file_.string(), map.label, e.what()));
      return nullptr;
    }
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

  void finish(Material& material, const aiColor4D& factor, const Alpha& alpha, std::shared_ptr<const Texture> image,
              bool colored) const {
    const bool tested = alpha.wanted && image && image->hasAlpha;
    const float plain = 0.2126f * factor.r + 0.7152f * factor.g + 0.0722f * factor.b;  // Rec. 709, linear
    if (colored) {
      material.textureMean = meanLuminance(*image, tested ? alpha.cutoff : 0.0f);
      // Outside glTF the colour beside a texture is what the exporter happened to leave there, often black.
      material.reflectance = material.textureMean * (gltf_ ? plain : 1.0f);
    } else {
      material.reflectance = plain;
    }
    material.textured = colored && options_.textures;
    material.alphaTested = tested;
    material.alphaCutoff = tested ? alpha.cutoff : 0.5f;
    if (tested || material.textured) material.texture = std::move(image);
  }

  const aiScene& scene_;
  const std::filesystem::path& file_;
  bool gltf_;
  const AssetOptions& options_;
};

// A name in a folder, whatever its case.
std::filesystem::path findIgnoringCase(const std::filesystem::path& folder, const std::string& name) {
  std::error_code error;
  std::filesystem::path best;  // the least, since the order of a folder is not stable
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (lower(entry.path().filename().string()) != lower(name) || !isFile(entry.path())) continue;
    if (best.empty() || entry.path() < best) best = entry.path();
  }
  return best;
}

}  // namespace

std::filesystem::path findTexture(const std::filesystem::path& asset, const std::string& name) {
  std::string plain = name;
  std::replace(plain.begin(), plain.end(), '\\', '/');
  const std::filesystem::path folder = asset.parent_path();
  std::vector<std::filesystem::path> candidates;
  if (plain.starts_with("file://")) plain = plain.substr(7);
  if (plain.starts_with("model://")) {  // Gazebo: model://MODEL/..., the models lie beside one another
    plain = plain.substr(8);
    std::filesystem::path up = folder;
    for (int level = 0; level < 4; ++level, up /= "..") candidates.push_back(up / plain);
  }
  // An absolute name replaces the folder.
  for (const std::string& spelling : {plain, decodeUri(plain)}) candidates.push_back(folder / spelling);
  const std::array<std::filesystem::path, 6> folders{folder,
                                                     folder / "textures",
                                                     folder / "Textures",
                                                     folder / ".." / "materials" / "textures",
                                                     folder / ".." / "textures",
                                                     folder / "materials" / "textures"};
  const std::string bare = decodeUri(std::filesystem::path(plain).filename().string());
  if (bare.empty()) return {};
  for (const auto& place : folders) candidates.push_back(place / bare);
  for (const auto& candidate : candidates) {
    if (isFile(candidate)) return candidate;
  }
  for (const auto& place : folders) {
    if (auto found = findIgnoringCase(place.empty() ? "." : place, bare); !found.empty()) return found;
  }
  return {};
}

std::vector<AssetMaterial> readMaterials(const aiScene& scene, const std::filesystem::path& file, bool gltf,
                                         const AssetOptions& options) {
  const MaterialReader reader(scene, file, gltf, options);
  std::vector<AssetMaterial> materials;
  for (unsigned i = 0; i < scene.mNumMaterials; ++i) materials.push_back(reader.read(i));
  return materials;
}

}  // namespace scanmill
