#pragma once

// How surfaces reflect near-infrared light: labels/materials.yaml, and what assets say of themselves.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/vec.h"

namespace scanmill {

// An image in memory: 8 bit, linear for alpha; `rgb` are sRGB values as stored.
struct Texture {
  std::string file;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  bool hasAlpha = false;           // some texel is below 255
  std::vector<std::uint8_t> rgba;  // width * height * 4, the first row is v = 0 (the image's bottom)

  // Nearest texel at u, v with repeat; 0 to 1 each.
  const std::uint8_t* texel(float u, float v) const;
};

struct Material {
  std::string name;
  float reflectance = 0.3f;       // near-infrared, 0 to 1
  float roughness = 1.0f;         // 0 mirror to 1 matt (glTF's perceptual roughness)
  float metallic = 0.0f;          // 0 or 1, as glTF
  float retroreflectance = 0.0f;  // added reflectance towards the sensor, in units of a white Lambertian target
  std::string source;             // of the reflectance
  bool textured = false;  // reflectance is scaled by the base colour's luminance at the hit over the texture's mean
  std::shared_ptr<const Texture> texture;  // base colour; null where none is needed
  float textureMean = 1.0f;                // mean linear luminance of the texture
  bool alphaTested = false;                // texels with alpha below alphaCutoff let the beam pass
  float alphaCutoff = 0.5f;
};

// Named materials of labels/materials.yaml. find() throws InputError at `where` with a suggestion.
struct MaterialLibrary {
  std::vector<Material> materials;
  const Material& require(std::string_view name, const Location& where) const;
};

// Wavelength in nm picks the column of reflectance: 850, 905 or 1064; default 905.
MaterialLibrary readMaterials(const std::filesystem::path& path, int wavelengthNm = 905);

}  // namespace scanmill
