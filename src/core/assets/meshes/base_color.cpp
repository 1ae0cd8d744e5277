#include "assets/meshes/base_color.h"

#include <fmt/format.h>

#include <cstdint>
#include <vector>

#include "assets/meshes/imported_file.h"
#include "assets/meshes/references.h"
#include "base/error.h"
#include "base/input_budget.h"
#include "base/short_text.h"
#include "images/images.h"
#include "images/srgb.h"
#include "scene/texture.h"

namespace scanmill {

namespace {

constexpr int kPointRows = 8;  // rows of sample points in a triangle; row i has kPointRows - i points
constexpr int kPoints = kPointRows * (kPointRows + 1) / 2;
constexpr std::uint64_t kMostSampledTriangles = 1 << 14;

// Numbers of sample points on a material's triangles. Each point is weighted by twice the area of its triangle.
struct AlphaAreas {
  double all = 0;
  double low = 0;     // points with alpha below 0.5
  double graded = 0;  // points with alpha from 0.1 to 0.9
  double gone = 0;    // points of triangles that an alpha test would remove: alpha is below 0.5 everywhere
};

// Adds the sample points of a triangle, whose part must have texture coordinates. Skips triangles that are not finite.
void addTriangle(AlphaAreas& areas, const AssetPart& part, const Triangle& triangle, const Texture& texture) {
  const auto [i0, i1, i2] = triangle;
  const auto& p = part.positions;
  const double doubleArea = length(cross(Vec3d(p[i1] - p[i0]), Vec3d(p[i2] - p[i0])));
  if (!std::isfinite(doubleArea)) return;
  const auto& uv = part.uvs;
  int low = 0, graded = 0;
  for (int row = 0; row < kPointRows; ++row) {
    for (int k = 0; k < kPointRows - row; ++k) {
      // Barycentric coordinates of the sample point.
      const float b = (static_cast<float>(row) + 1.0f / 3) / kPointRows;
      const float c = (static_cast<float>(k) + 1.0f / 3) / kPointRows;
      const float a = 1 - b - c;
      const int alpha =
          texture.texel(uv[i0].x * a + uv[i1].x * b + uv[i2].x * c, uv[i0].y * a + uv[i1].y * b + uv[i2].y * c)[3];
      low += alpha < 128 ? 1 : 0;
      graded += isGradedAlpha(alpha) ? 1 : 0;
    }
  }
  areas.all += doubleArea * kPoints;
  areas.low += doubleArea * low;
  areas.graded += doubleArea * graded;
  if (low == kPoints) areas.gone += doubleArea * kPoints;
}

// True if a material's texture seems to have cut-outs: some of the surface is cut away, the alpha is mostly 0 or 1, and
// hardly any triangle would vanish completely, since nobody models triangles that are never seen. If alpha instead
// marks the painted parts of a car's body, complete panels have a low alpha. In measurements on Gazebo's models, 0 and
// 8 % of the area would vanish from the branches of oak and pine, and 24, 35 and 53 % from the bodies of bus, hatchback
// and SUV. Measures alpha at 36 points of each triangle, or of every n-th triangle if there are 16384 or more.
bool isCutOut(const ImportedFile& imported, std::uint32_t material, const Texture& texture) {
  if (!texture.hasAlpha) return false;
  const auto showsTexture = [&](const AssetPart& part) { return part.materialIndex == material && !part.uvs.empty(); };
  std::uint64_t triangles = 0;
  for (const AssetPart& part : imported.parts) triangles += showsTexture(part) ? part.triangles.size() : 0;
  const std::uint64_t step = triangles / kMostSampledTriangles + 1;
  AlphaAreas areas;
  std::uint64_t triangleIndex = 0;
  for (const AssetPart& part : imported.parts) {
    if (!showsTexture(part)) continue;
    for (const Triangle& triangle : part.triangles) {
      if (triangleIndex++ % step == 0) addTriangle(areas, part, triangle, texture);
    }
  }
  // Fractions of the weighted area. kMostGone lies between the 8 % and 24 % above; the other two are chosen by eye.
  constexpr double kLeastLow = 0.01, kMostGraded = 0.3, kMostGone = 0.15;
  return areas.all > 0 && areas.low >= kLeastLow * areas.all && areas.graded <= kMostGraded * areas.all &&
         areas.gone <= kMostGone * areas.all;
}

// Loads the images of the material with this index, and decides whether their alpha is tested.
BaseColor colorOf(ImportedFile& imported, std::uint32_t index, const AssetOptions& options, ColorImages& images) {
  using enum BaseColor::Source;
  using Need = ColorImages::Need;
  const ImportedMaterial& material = imported.materials[index];
  const std::string& name = material.base.name;
  const ImportedMap& map = material.opacityMap;
  BaseColor color{.source = !name.empty() ? Image : material.stated ? Factor : None, .factor = material.color};
  bool testsAlpha = options.alpha != AlphaUse::Ignore;
  if (!name.empty() && (options.textures || testsAlpha)) {
    color.image = images.load(name, name, options.textures ? Need::AnyImage : Need::ImageWithAlpha);
  }
  // An opacity of 0 declares nothing: it comes from exporters that confuse opacity with transparency.
  const bool declaresAlpha =
      options.alpha == AlphaUse::Test || !map.name.empty() || (material.opacity > 0 && material.opacity < 1);
  if (color.image && testsAlpha && !declaresAlpha && !isCutOut(imported, index, *color.image)) {
    testsAlpha = false;
    if (!options.textures) color.image.reset();
  }
  // If there is an image, the factor is ignored: exporters leave arbitrary values in the factor, often black.
  if (color.image) color.factor = {1, 1, 1};
  if (!testsAlpha) return color;
  color.alphaCutoff = kUsualAlphaCutoff;
  // If the opacity map and the base colour name the same file, the opacity is the alpha of this file. The image already
  // has this alpha, unless the map is inverted.
  if (!map.name.empty() && (map.name != name || map.inverted)) {
    if (const auto mask = images.load(map.name, map.name, Need::AnyImage)) {
      (color.image ? color.image : color.opacity) = withOpacity(color.image.get(), *mask, map.inverted);
    }
  }
  if (map.name == name && color.image && !color.image->hasAlpha) {
    imported.leftOut.add("opacity maps that are the image of the colour too, and have no alpha");
  }
  return color;
}

}  // namespace

void setColor(Material& material, const BaseColor& color, const std::filesystem::path& file,
              const AssetOptions& options, ColorImages& images) {
  const auto& [r, g, b] = color.factor;
  material.reflectance = 0.2126f * r + 0.7152f * g + 0.0722f * b;  // luminance of the factor (Rec. 709, linear)
  const std::shared_ptr<const Texture>& texture = color.image ? color.image : color.opacity;
  material.alphaTested = color.alphaCutoff && texture && texture->hasAlpha;
  material.alphaCutoff = material.alphaTested ? *color.alphaCutoff : kUsualAlphaCutoff;
  if (color.image) {
    material.textureMean = images.mean(color.image, material.alphaTested ? material.alphaCutoff : 0.0f);
    material.reflectance *= material.textureMean;
  }
  material.textured = color.image != nullptr && options.textures;
  if (material.alphaTested || material.textured) material.texture = texture;
  // A factor other than white is a colour, even if the image that it multiplies is missing.
  const bool isColorKnown = color.source == BaseColor::Source::Factor ||
                            (color.source == BaseColor::Source::Image && (color.image || r != 1 || g != 1 || b != 1));
  if (isColorKnown) return;
  const Material fallback;
  material.reflectance = fallback.reflectance;
  material.metallic = fallback.metallic;
  material.source = "default: " + file.filename().string() + " has no colour";
}

ColorImages::~ColorImages() {
  constexpr std::size_t kMostNames = 8;
  if (missing_.empty()) return;
  std::vector<std::string> names;
  for (const std::string& name : missing_) names.push_back(fmt::format("'{}'", name));
  warn(
      "{}: missing textures: {}; plain colours replace them, and what their alpha would cut out is "
      "solid; `textures` of the object names further folders",
      asset_.string(), shortList(names, kMostNames));
}

std::shared_ptr<const Texture> ColorImages::load(const std::string& key, const std::string& name, Need need,
                                                 const std::function<std::shared_ptr<const Texture>()>& embedded) {
  const auto [entry, isNew] = images_.try_emplace({key, need});
  std::shared_ptr<const Texture>& image = entry->second;
  if (!isNew) return image;
  std::filesystem::path path;
  if (!embedded) {
    path = findTexture(asset_, name, allowOutside_, folders_);
    if (path.empty()) missing_.insert(name);
    if (path.empty() || (need == Need::ImageWithAlpha && !mayHaveAlpha(path))) return nullptr;
  }
  try {
    image = embedded ? embedded() : loadTexture(path);
    if (need == Need::ImageWithAlpha && !image->hasAlpha) image = nullptr;
  } catch (const InputLimitError&) {
    throw;
  } catch (const InputError& e) {
    warn("{}: the texture '{}' cannot be used: {}", asset_.string(), name, e.what());
  }
  return image;
}

std::shared_ptr<const Texture> ColorImages::tinted(const std::shared_ptr<const Texture>& image,
                                                   const std::array<float, 3>& factor) {
  std::shared_ptr<const Texture>& cached = tinted_[{image, factor}];
  if (cached != nullptr) return cached;
  auto texture = std::make_shared<Texture>(*image);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    std::array<std::uint8_t, 256> tintedBytes{};  // results, by byte of the image
    for (std::size_t i = 0; i < tintedBytes.size(); ++i) {
      const double light = double{linearOfBytes()[i] * factor[channel]};
      tintedBytes[i] = static_cast<std::uint8_t>(std::lround(255 * srgbOf(light)));
    }
    for (std::size_t i = channel; i < texture->rgba.size(); i += 4) texture->rgba[i] = tintedBytes[texture->rgba[i]];
  }
  return cached = std::move(texture);
}

float ColorImages::mean(const std::shared_ptr<const Texture>& image, float leastAlpha) {
  const auto [entry, isNew] = means_.emplace(std::pair{image, leastAlpha}, 0.0f);
  if (isNew) entry->second = meanLuminance(*image, leastAlpha);
  return entry->second;
}

std::vector<Look> readMaterials(ImportedFile& imported, const std::filesystem::path& file,
                                const AssetOptions& options) {
  ColorImages images(file, options.allowOutside, options.textureFolders);
  std::vector<Look> looks;
  for (std::uint32_t i = 0; i < imported.materials.size(); ++i) {
    ImportedMaterial& material = imported.materials[i];
    for (std::string* const name : {&material.base.name, &material.opacityMap.name}) {
      if (*name == "(null)") name->clear();  // exporters print a missing name so
    }
    const BaseColor color = colorOf(imported, i, options, images);
    Look& look = looks.emplace_back();
    look.material = look.fileMaterial.name = material.name;
    look.fileMaterial.source = "base colour of " + file.filename().string();
    look.fileMaterial.roughness = material.roughness;
    look.fileMaterial.metallic = material.metallic;
    look.texture = material.base.name;
    look.color = color.factor;
    setColor(look.fileMaterial, color, file, options, images);
    if (material.opacity < 1 && !look.fileMaterial.alphaTested && options.alpha != AlphaUse::Ignore) {
      imported.leftOut.add("opacities of materials (they are solid)");
    }
  }
  return looks;
}

}  // namespace scanmill
