#pragma once

// What the base colour of an asset's material, and the alpha beside it, mean to a beam.

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "scene/assets/asset.h"

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

// Sets reflectance and texture of the material. White beside a texture that is not there is no colour of its own.
void setColor(Material& material, BaseColor color, const std::filesystem::path& file, const AssetOptions& options);

// The texture that the asset at `asset` calls `name`: what `embedded` returns, or else the file that it names. Null,
// with a warning, where it is missing or broken; null where only alpha is wanted and there is none.
std::shared_ptr<const Texture> loadColor(const std::filesystem::path& asset, const std::string& name, bool onlyAlpha,
                                         const std::function<std::shared_ptr<const Texture>()>& embedded);

// From 0 to 1; the fallback where it is not finite.
template <class Number>
Number fraction(Number value, Number fallback) {
  return std::isfinite(value) ? std::clamp(value, Number(0), Number(1)) : fallback;
}

}  // namespace scanmill
