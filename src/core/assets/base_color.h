#pragma once

// What the base colour of an asset's material, and the alpha beside it, mean to a beam.

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

#include "assets/asset.h"

namespace scanmill {

struct AlphaTest {
  bool wanted = false;  // beams pass where the image's alpha is below
  float cutoff = 0.5f;
};

struct BaseColor {
  std::array<float, 3> factor{1, 1, 1};  // linear
  bool tints = false;                    // the factor multiplies the image
  bool stated = true;                    // false: no material of the file, but one that stands for none
  bool textured = false;                 // it names an image, which may be absent
  std::shared_ptr<const Texture> image;  // with its alpha, or null
  bool colored = false;                  // the image has colours
  AlphaTest alpha;
};

// The images that the materials of one asset name. Each is looked for, decoded and measured once, however many
// materials show it.
class ColorImages {
 public:
  // `allowOutside`: see findTexture().
  ColorImages(std::filesystem::path asset, bool allowOutside) : asset_(std::move(asset)), allowOutside_(allowOutside) {}
  // Warns of those that were missing, in one line, and in another of those whose alpha may cut out.
  ~ColorImages();
  ColorImages(const ColorImages&) = delete;
  ColorImages& operator=(const ColorImages&) = delete;

  // What the asset calls `name`: what `embedded` returns, or else the file of that name. Null, with a warning, where it
  // is missing or broken; null where only alpha is wanted and there is none. `cutsOut`: its alpha would let beams pass,
  // which the warning tells. No other image has its `key`.
  std::shared_ptr<const Texture> load(const std::string& key, const std::string& name, bool onlyAlpha, bool cutsOut,
                                      const std::function<std::shared_ptr<const Texture>()>& embedded);

  // meanLuminance() of the image.
  float mean(const std::shared_ptr<const Texture>& image, float leastAlpha);

 private:
  std::shared_ptr<const Texture> find(const std::string& name, bool onlyAlpha, bool cutsOut,
                                      const std::function<std::shared_ptr<const Texture>()>& embedded);

  std::filesystem::path asset_;
  bool allowOutside_;
  std::set<std::string> missing_;
  std::set<std::string> missingCutOuts_;  // whose alpha may cut out
  std::map<std::pair<std::string, bool>, std::shared_ptr<const Texture>> images_;
  std::map<std::pair<std::shared_ptr<const Texture>, float>, float> means_;
};

// Sets reflectance and texture of a material of the asset `file`. White beside a texture that is not there is no colour
// of its own.
void setColor(Material& material, BaseColor color, const std::filesystem::path& file, const AssetOptions& options,
              ColorImages& images);

// From 0 to 1; the fallback where it is not finite.
template <class Number>
Number fraction(Number value, Number fallback) {
  return std::isfinite(value) ? std::clamp(value, Number(0), Number(1)) : fallback;
}

}  // namespace scanmill
