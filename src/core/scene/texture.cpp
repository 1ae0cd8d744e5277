#include "scene/texture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <utility>

#include "base/input_budget.h"
#include "images/images.h"
#include "images/srgb.h"
#include "scene/reflectance.h"

namespace scanmill {
namespace {

// Makes a texture from an image, with the rows in reverse order, since v = 0 is the image's bottom.
std::shared_ptr<const Texture> textureOf(DecodedImage image, const std::string& name) {
  const std::size_t rowBytes = std::size_t{image.width} * 4;
  std::uint8_t* const pixels = image.rgba.data();
  for (std::size_t row = 0; row < image.height / 2; ++row) {
    std::uint8_t* const mirrorRow = pixels + (image.height - 1 - row) * rowBytes;
    std::swap_ranges(pixels + row * rowBytes, pixels + (row + 1) * rowBytes, mirrorRow);
  }
  return std::make_shared<Texture>(Texture{.file = name,
                                           .width = image.width,
                                           .height = image.height,
                                           .hasAlpha = image.hasAlpha,
                                           .linear = image.linear,
                                           .rgba = std::move(image.rgba)});
}

// A texture that some scene may still use.
struct CachedTexture {
  std::filesystem::file_time_type time;  // when the file was last changed
  std::weak_ptr<const Texture> texture;
};

// Returns the index of the texel that contains `coordinate`, with repetition; 0 if the coordinate is not finite.
std::uint32_t texelIndex(float coordinate, std::uint32_t size) {
  const float fraction = coordinate - std::floor(coordinate);
  return fraction > 0.0f ? std::min(static_cast<std::uint32_t>(fraction * static_cast<float>(size)), size - 1) : 0;
}

}  // namespace

const std::uint8_t* Texture::texel(float u, float v) const {
  return rgba.data() + (std::size_t{texelIndex(v, height)} * width + texelIndex(u, width)) * 4;
}

std::shared_ptr<const Texture> loadTexture(const std::filesystem::path& path) {
  recordFile(path);  // also for a cached texture: each scene that uses the texture records its file
  static std::mutex mutex;
  static std::map<std::string, CachedTexture> cache;
  std::error_code error;
  const std::string key = std::filesystem::weakly_canonical(path, error).string();
  const auto time = std::filesystem::last_write_time(path, error);
  const auto cached = [&]() -> std::shared_ptr<const Texture> {
    const auto entry = cache.find(key);
    return entry != cache.end() && entry->second.time == time ? entry->second.texture.lock() : nullptr;
  };
  {
    const std::scoped_lock lock(mutex);
    if (auto texture = cached()) return texture;
  }
  auto texture = textureOf(readImage(path), path.string());
  const std::scoped_lock lock(mutex);
  if (auto cachedMeanwhile = cached()) return cachedMeanwhile;  // another thread has loaded it
  cache[key] = {time, texture};
  return texture;
}

std::shared_ptr<const Texture> decodeTexture(std::string_view bytes, const std::string& name) {
  return textureOf(decodeImage(bytes, name), name);
}

std::shared_ptr<const Texture> withOpacity(const Texture* color, const Texture& opacity, bool inverted) {
  auto texture = std::make_shared<Texture>();
  texture->file = color != nullptr ? color->file : opacity.file;
  texture->width = std::max(opacity.width, color != nullptr ? color->width : 0);
  texture->height = std::max(opacity.height, color != nullptr ? color->height : 0);
  texture->rgba.resize(std::size_t{texture->width} * texture->height * 4);
  std::uint8_t* out = texture->rgba.data();
  for (std::uint32_t row = 0; row < texture->height; ++row) {
    const float v = (static_cast<float>(row) + 0.5f) / static_cast<float>(texture->height);
    for (std::uint32_t column = 0; column < texture->width; ++column, out += 4) {
      const float u = (static_cast<float>(column) + 0.5f) / static_cast<float>(texture->width);
      const std::uint8_t* mapTexel = opacity.texel(u, v);
      const int alpha = opacity.hasAlpha ? mapTexel[3]
                        : opacity.linear ? static_cast<int>(std::lround(255 * luminance(mapTexel)))
                                         : (mapTexel[0] + mapTexel[1] + mapTexel[2] + 1) / 3;
      out[3] = static_cast<std::uint8_t>(inverted ? 255 - alpha : alpha);
      if (color != nullptr) {
        std::copy_n(color->texel(u, v), 3, out);
      } else {
        std::fill_n(out, 3, std::uint8_t{255});
      }
      texture->hasAlpha = texture->hasAlpha || out[3] < 255;
    }
  }
  return texture;
}

float luminance(const std::uint8_t* rgb) {
  const std::array<float, 256>& linear = linearOfBytes();
  return 0.2126f * linear[rgb[0]] + 0.7152f * linear[rgb[1]] + 0.0722f * linear[rgb[2]];
}

float meanLuminance(const Texture& texture, float minimumAlpha) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i + 3 < texture.rgba.size(); i += 4) {
    if (static_cast<float>(texture.rgba[i + 3]) < minimumAlpha * 255.0f) continue;
    sum += static_cast<double>(luminance(&texture.rgba[i]));
    ++count;
  }
  return count == 0 ? 1.0f : static_cast<float>(sum / static_cast<double>(count));
}

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
  for (const Material& material : scene.materials) materials.push_back(compact(material));
  return materials;
}

}  // namespace scanmill
