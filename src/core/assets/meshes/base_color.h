#pragma once

// Derives the reflectance and the alpha test of an asset's material from its base colour and that colour's alpha.

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "assets/meshes/asset_data.h"

namespace scanmill {

struct AlphaTest {
  bool wanted = false;  // true: beams pass where the image's alpha is below `cutoff`
  float cutoff = 0.5f;
};

struct BaseColor {
  std::array<float, 3> factor{1, 1, 1};       // red, green, blue; linear
  bool tints = false;                         // true: the factor multiplies the image
  bool stated = true;                         // false: the file states no material, and this colour is a substitute
  bool textured = false;                      // true: the material names an image, which may be absent
  std::shared_ptr<const Texture> image = {};  // null: absent, or not loaded
  bool colored = false;                       // true: the image has colours, not only alpha
  AlphaTest alpha = {};
};

// The images that the materials of an asset name. Each image is searched for, decoded and measured only once, however
// many materials use it.
class ColorImages {
 public:
  // `allowOutside` and `folders`: see findTexture().
  ColorImages(std::filesystem::path asset, bool allowOutside, std::vector<std::filesystem::path> folders = {})
      : asset_(std::move(asset)), allowOutside_(allowOutside), folders_(std::move(folders)) {}
  // Warns of missing images.
  ~ColorImages();
  ColorImages(const ColorImages&) = delete;
  ColorImages& operator=(const ColorImages&) = delete;

  // Returns the image that the asset calls `name`: the result of `embedded`, or if that is absent or null the file
  // `name`. Returns null if the image is missing (the destructor warns), is broken (warns), or has no alpha although
  // `onlyAlpha` is set. `key` identifies the image.
  std::shared_ptr<const Texture> load(const std::string& key, const std::string& name, bool onlyAlpha,
                                      const std::function<std::shared_ptr<const Texture>()>& embedded = {});

  // Returns the image with its linear red, green and blue multiplied by `factor`, of 0 to 1.
  std::shared_ptr<const Texture> tinted(const std::shared_ptr<const Texture>& image,
                                        const std::array<float, 3>& factor);

  // Returns meanLuminance(*image, leastAlpha).
  float mean(const std::shared_ptr<const Texture>& image, float leastAlpha);

 private:
  std::shared_ptr<const Texture> find(const std::string& name, bool onlyAlpha,
                                      const std::function<std::shared_ptr<const Texture>()>& embedded);

  std::filesystem::path asset_;
  bool allowOutside_;
  std::vector<std::filesystem::path> folders_;
  std::set<std::string> missing_;
  std::map<std::pair<std::string, bool>, std::shared_ptr<const Texture>> images_;
  std::map<std::pair<std::shared_ptr<const Texture>, std::array<float, 3>>, std::shared_ptr<const Texture>> tinted_;
  std::map<std::pair<std::shared_ptr<const Texture>, float>, float> means_;
};

// Sets reflectance and texture of a material of the asset `file`. A material that the file does not state gets the
// default reflectance, and so does a material whose image is not loaded and whose colour factor is white, since white
// then only means "unchanged image".
void setColor(Material& material, BaseColor color, const std::filesystem::path& file, const AssetOptions& options,
              ColorImages& images);

// True if an alpha is neither near 0 nor near 1: from 0.1 to 0.9.
inline bool isGradedAlpha(int alpha) {
  return alpha >= 26 && alpha < 230;
}

// Returns the value, clamped to 0 to 1; the fallback if the value is not finite.
template <class Number>
Number fraction(Number value, Number fallback) {
  return std::isfinite(value) ? std::clamp(value, Number(0), Number(1)) : fallback;
}

}  // namespace scanmill
