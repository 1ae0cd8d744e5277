#pragma once

// Derives the reflectance and the alpha test of an asset's material from its base colour and that colour's alpha.

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "assets/meshes/asset_data.h"

namespace scanmill {

// The base colour of a material, as the asset's file states it.
struct BaseColor {
  enum class Source {
    None,    // the file states no colour
    Factor,  // a colour without an image
    Image,   // an image, which may be missing or not loaded
  };
  Source source = Source::Factor;
  std::array<float, 3> factor{1, 1, 1};      // red, green, blue; linear. Multiplies the image, if it is loaded
  std::shared_ptr<const Texture> image{};    // image of Source::Image; null: not loaded
  std::shared_ptr<const Texture> opacity{};  // tested for alpha if `image` is null; its colours do not count
  // Beams pass where alpha is below this value (0 to 1); nullopt: they never pass.
  std::optional<float> alphaCutoff = std::nullopt;
};

constexpr float kUsualAlphaCutoff = 0.5f;  // glTF's default; also used if the file states no cutoff

// The images that the materials of an asset name. Each image is searched for, decoded and measured only once, however
// many materials use it.
class ColorImages {
 public:
  // `asset`: the file. `allowOutside` and `folders`: see findTexture().
  ColorImages(std::filesystem::path asset, bool allowOutside, std::vector<std::filesystem::path> folders = {})
      : asset_(std::move(asset)), allowOutside_(allowOutside), folders_(std::move(folders)) {}
  // Warns of missing images.
  ~ColorImages();
  ColorImages& operator=(ColorImages&&) = delete;  // neither copied nor moved

  // Returns the image that the asset calls `name`: the result of `embedded` or, if this is absent, the file `name`.
  // Returns null if the image is missing (the destructor warns), is broken (warns), or has no alpha although only
  // images with alpha are needed. `key` identifies the image in the cache.
  enum class Need { AnyImage, ImageWithAlpha };
  std::shared_ptr<const Texture> load(const std::string& key, const std::string& name, Need need,
                                      const std::function<std::shared_ptr<const Texture>()>& embedded = {});

  // Returns the image with its linear red, green and blue multiplied by the components of `factor` (0 to 1).
  std::shared_ptr<const Texture> tinted(const std::shared_ptr<const Texture>& image,
                                        const std::array<float, 3>& factor);

  // Returns meanLuminance(*image, leastAlpha), which is computed only once.
  float mean(const std::shared_ptr<const Texture>& image, float leastAlpha);

 private:
  std::filesystem::path asset_;
  bool allowOutside_;
  std::vector<std::filesystem::path> folders_;
  std::set<std::string> missing_;                                                  // names of missing images
  std::map<std::pair<std::string, Need>, std::shared_ptr<const Texture>> images_;  // images so far, by key
  std::map<std::pair<std::shared_ptr<const Texture>, std::array<float, 3>>, std::shared_ptr<const Texture>> tinted_;
  std::map<std::pair<std::shared_ptr<const Texture>, float>, float> means_;
};

// Sets reflectance and texture of a material of the asset `file`. The reflectance is the default if the material has no
// colour, or if its image is not loaded and its factor is white, since white then only means "unchanged image".
void setColor(Material& material, const BaseColor& color, const std::filesystem::path& file,
              const AssetOptions& options, ColorImages& images);

// True if an alpha from 0 to 255 is neither near 0 nor near 255: from 10 % to 90 %.
inline bool isGradedAlpha(int alpha) {
  return alpha >= 26 && alpha < 230;
}

// Returns the value, clamped to 0 to 1; the fallback if the value is not finite.
template <class Number>
Number fraction(Number value, Number fallback) {
  return std::isfinite(value) ? std::clamp(value, Number(0), Number(1)) : fallback;
}

}  // namespace scanmill
