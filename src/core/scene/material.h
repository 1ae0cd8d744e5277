#pragma once

// How surfaces reflect near-infrared light. The figures come from labels/materials.yaml and from assets. This
// header is installed because scene/scene.h includes it.
//
//   const MaterialLibrary library = readMaterials("labels/materials.yaml", 905);
//   const float reflectance = library.require("asphalt", {}).reflectance;

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/vec.h"

namespace scanmill {

// An image in memory, 8 bit per channel. Red, green and blue are stored sRGB values; alpha is linear.
struct Texture {
  std::string file;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  bool hasAlpha = false;           // true: a texel has an alpha below 255
  bool linear = false;             // true: the file has linear light, from which the sRGB values were computed
  std::vector<std::uint8_t> rgba;  // width * height * 4 bytes; the first row is v = 0 (the image's bottom)

  // Returns a pointer to the four bytes of the nearest texel at the texture coordinates u, v. The texture repeats
  // outside of 0 to 1.
  const std::uint8_t* texel(float u, float v) const;
};

// How much the reflectance differs from place to place, over distances of about `size`.
struct Variation {
  float size = 1;      // m, distance over which the reflectance varies
  float contrast = 0;  // standard deviation of the reflectance's natural logarithm
  bool operator==(const Variation&) const = default;
};

constexpr std::size_t kMostVariations = 4;

// How rough a surface is, over distances of about `size`.
struct Relief {
  float size = 1;    // m, horizontal size of the bumps
  float height = 0;  // m, standard deviation (rms height)
  bool operator==(const Relief&) const = default;
};

constexpr std::size_t kMostReliefs = 2;

struct Material {
  std::string name;
  float reflectance = 0.3f;       // near-infrared, 0 to 1
  float least = 0.3f;             // lower limit of `reflectance` in different places
  float greatest = 0.3f;          // upper limit; without a range in the table both limits are `reflectance`
  float roughness = 1.0f;         // 0 mirror to 1 matt (glTF's perceptual roughness)
  float metallic = 0.0f;          // 0 to 1, as in glTF
  float retroreflectance = 0.0f;  // added reflectance towards the sensor, in units of a white Lambertian target
  float transmission = 0.0f;      // part of the light that the inside of a pane lets through, 0 to 1; 0: opaque
  float index = 1.52f;            // refractive index
  std::string source = {};        // source of the reflectance, such as a measured spectrum
  std::vector<Variation> variations = {};  // used by the effect reflectance_variation; at most kMostVariations
  std::vector<Relief> relief = {};         // used by the effect relief; at most kMostReliefs
  bool textured = false;                   // true: the reflectance is multiplied by texture luminance / textureMean
  std::shared_ptr<const Texture> texture = nullptr;  // base colour; null: none
  float textureMean = 1.0f;                          // mean linear luminance of the texture
  bool alphaTested = false;                          // true: beams pass texels with alpha below alphaCutoff
  float alphaCutoff = 0.5f;
  bool operator==(const Material&) const = default;
};

// The materials of a table such as labels/materials.yaml. require() returns the material called `name`. If there is
// none, it throws an InputError at `where`, with a suggestion.
struct MaterialLibrary {
  std::vector<Material> materials;
  const Material& require(std::string_view name, const Location& where) const;
};

// Reads a table of materials. `wavelengthNm` selects the reflectances at 850, 905, 1064 or 1550 nm. Throws InputError
// with the place in the file.
MaterialLibrary readMaterials(const std::filesystem::path& path, int wavelengthNm = 905);

}  // namespace scanmill
