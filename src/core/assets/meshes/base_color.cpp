#include "assets/meshes/base_color.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdint>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "assets/meshes/imported_file.h"
#include "assets/meshes/references.h"
#include "base/error.h"
#include "base/input_budget.h"
#include "images/images.h"
#include "images/srgb.h"
#include "scene/texture.h"

namespace scanmill {

namespace {

constexpr int kSteps = 8;  // rows of sample points in a triangle; row i has kSteps - i points
constexpr int kPoints = kSteps * (kSteps + 1) / 2;
constexpr std::uint64_t kMaxTriangles = 1 << 14;

// Areas of triangles that have one material and texture coordinates, in units of a sample point's share.
struct AlphaAreas {
  double all = 0;
  double low = 0;     // with alpha below 0.5
  double graded = 0;  // with alpha from 0.1 to 0.9
  double gone = 0;    // of triangles that a test of alpha would remove, since it is below 0.5 everywhere
};

void addTriangle(AlphaAreas& areas, const AssetPart& part, const Triangle& at, const Texture& texture) {
  const auto& p = part.positions;
  const double area = length(cross(Vec3d(p[at[1]] - p[at[0]]), Vec3d(p[at[2]] - p[at[0]])));
  if (!std::isfinite(area)) return;
  const auto& uv = part.uvs;
  int low = 0, graded = 0;
  for (int i = 0; i < kSteps; ++i) {
    for (int k = 0; k < kSteps - i; ++k) {
      const float b = (static_cast<float>(i) + 1.0f / 3) / kSteps;
      const float c = (static_cast<float>(k) + 1.0f / 3) / kSteps;
      const float a = 1 - b - c;
      const int alpha = texture.texel(uv[at[0]].x * a + uv[at[1]].x * b + uv[at[2]].x * c,
                                      uv[at[0]].y * a + uv[at[1]].y * b + uv[at[2]].y * c)[3];
      low += alpha < 128 ? 1 : 0;
      graded += isGradedAlpha(alpha) ? 1 : 0;
    }
  }
  areas.all += area * kPoints;
  areas.low += area * low;
  areas.graded += area * graded;
  if (low == kPoints) areas.gone += area * kPoints;
}

// True if a material's texture seems to have cut-outs: some of the surface is cut away, the alpha is mostly 0 or 1, and
// hardly any triangle would vanish completely, since nobody models triangles that are never seen. If alpha instead
// marks the painted parts of a car's body, complete panels have a low alpha. In measurements on Gazebo's models, 0 and
// 8 % of the area would vanish from the branches of oak and pine, and 24, 35 and 53 % from the bodies of bus, hatchback
// and SUV. Measures alpha at 36 points of each triangle, or of every n-th triangle if there are 16384 or more.
bool isCutOut(const ImportedFile& imported, std::uint32_t material, const Texture& texture) {
  if (!texture.hasAlpha) return false;
  const auto shows = [&](const AssetPart& part) { return part.materialIndex == material && !part.uvs.empty(); };
  std::uint64_t triangles = 0;
  for (const AssetPart& part : imported.parts) triangles += shows(part) ? part.triangles.size() : 0;
  const std::uint64_t step = triangles / kMaxTriangles + 1;
  AlphaAreas areas;
  std::uint64_t number = 0;
  for (const AssetPart& part : imported.parts) {
    if (!shows(part)) continue;
    for (const Triangle& triangle : part.triangles) {
      if (number++ % step == 0) addTriangle(areas, part, triangle, texture);
    }
  }
  constexpr double kLeastLow = 0.01, kMostGraded = 0.3, kMostGone = 0.15;
  return areas.all > 0 && areas.low >= kLeastLow * areas.all && areas.graded <= kMostGraded * areas.all &&
         areas.gone <= kMostGone * areas.all;
}

// Reads the materials of one file.
class MaterialReader {
 public:
  MaterialReader(const ImportedFile& imported, const std::filesystem::path& file, const AssetOptions& options)
      : imported_(imported),
        file_(file),
        options_(options),
        images_(file, options.allowOutside, options.textureFolders) {}

  Look read(std::uint32_t index, LeftOut& leftOut) {
    ImportedMaterial from = imported_.materials[index];
    for (ImportedMap* const map : {&from.base, &from.opacityMap}) {
      if (map->name == "(null)") *map = {};  // exporters print a missing name so
    }
    Look read;
    read.material = read.fileMaterial.name = from.name;
    read.fileMaterial.source = "base colour of " + file_.filename().string();
    read.fileMaterial.roughness = from.roughness;
    read.fileMaterial.metallic = from.metallic;
    read.texture = from.base.name;

    BaseColor color;
    color.factor = from.color;
    color.stated = from.stated;
    color.textured = !from.base.name.empty();
    color.alpha.wanted = options_.alpha != AlphaUse::Ignore;
    if (color.textured && (options_.textures || color.alpha.wanted)) {
      color.image = images_.load(from.base.name, from.base.name, !options_.textures);
    }
    if (color.image && color.alpha.wanted && !declaresAlpha(from) && !isCutOut(imported_, index, *color.image)) {
      color.alpha.wanted = false;
      if (!options_.textures) color.image.reset();
    }
    color.colored = color.image != nullptr;
    // If there is a texture, the colour factor is ignored: exporters leave arbitrary values in it, often black.
    if (!color.colored) read.color = color.factor;
    // If the opacity map is the same file as the base colour, it means that file's alpha, which the image already has,
    // unless it is inverted.
    const ImportedMap& opacity = from.opacityMap;
    if (color.alpha.wanted && !opacity.name.empty() && (opacity.name != from.base.name || opacity.inverted)) {
      if (const auto mask = images_.load(opacity.name, opacity.name, false))
        color.image = withOpacity(color.image.get(), *mask, opacity.inverted);
    }
    if (color.alpha.wanted && opacity.name == from.base.name && color.image && !color.image->hasAlpha) {
      leftOut.add("opacity maps that are the image of the colour too, and have no alpha");
    }
    setColor(read.fileMaterial, std::move(color), file_, options_, images_);
    if (from.opacity < 1 && !read.fileMaterial.alphaTested && options_.alpha != AlphaUse::Ignore) {
      leftOut.add("opacities of materials (they are solid)");
    }
    return read;
  }

 private:
  // True if the test of alpha applies without a check by isCutOut(). An opacity of 0 would hide the material: it comes
  // from exporters that confuse opacity with transparency, and is ignored.
  bool declaresAlpha(const ImportedMaterial& from) const {
    return options_.alpha == AlphaUse::Test || !from.opacityMap.name.empty() || (from.opacity > 0 && from.opacity < 1);
  }

  const ImportedFile& imported_;
  const std::filesystem::path& file_;
  const AssetOptions& options_;
  ColorImages images_;
};

}  // namespace

void setColor(Material& material, BaseColor color, const std::filesystem::path& file, const AssetOptions& options,
              ColorImages& images) {
  const auto& [r, g, b] = color.factor;
  const float luminance = 0.2126f * r + 0.7152f * g + 0.0722f * b;  // luminance of the factor (Rec. 709, linear)
  const bool tested = color.alpha.wanted && color.image && color.image->hasAlpha;
  if (color.colored) {
    material.textureMean = images.mean(color.image, tested ? color.alpha.cutoff : 0.0f);
    material.reflectance = material.textureMean * (color.tints ? luminance : 1.0f);
  } else {
    material.reflectance = luminance;
  }
  material.textured = color.colored && options.textures;
  material.alphaTested = tested;
  material.alphaCutoff = tested ? color.alpha.cutoff : 0.5f;
  if (tested || material.textured) material.texture = std::move(color.image);
  const bool isUnknown = !color.colored && color.textured && r == 1 && g == 1 && b == 1;
  if (!isUnknown && (color.stated || color.textured)) return;
  const Material fallback;
  material.reflectance = fallback.reflectance;
  material.metallic = fallback.metallic;
  material.source = "default: " + file.filename().string() + " has no colour";
}

ColorImages::~ColorImages() {
  constexpr std::size_t kMost = 8;
  if (missing_.empty()) return;
  const std::vector<std::string> first(missing_.begin(), std::next(missing_.begin(), std::min(missing_.size(), kMost)));
  warn(
      fmt::format("{}: missing textures: '{}'{}; plain colours replace them, and what their alpha would cut out is "
                  "solid; `textures` of the object names further folders",
                  asset_.string(), fmt::join(first, "', '"),
                  missing_.size() > kMost ? fmt::format(" and {} more", missing_.size() - kMost) : ""));
}

std::shared_ptr<const Texture> ColorImages::load(const std::string& key, const std::string& name, bool onlyAlpha,
                                                 const std::function<std::shared_ptr<const Texture>()>& embedded) {
  const auto known = images_.find({key, onlyAlpha});
  if (known != images_.end()) return known->second;
  return images_[{key, onlyAlpha}] = find(name, onlyAlpha, embedded);
}

std::shared_ptr<const Texture> ColorImages::tinted(const std::shared_ptr<const Texture>& image,
                                                   const std::array<float, 3>& factor) {
  std::shared_ptr<const Texture>& known = tinted_[{image, factor}];
  if (known != nullptr) return known;
  auto texture = std::make_shared<Texture>(*image);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    std::array<std::uint8_t, 256> bytes{};
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      bytes[i] = static_cast<std::uint8_t>(std::lround(255 * srgbOf(double{linearOfBytes()[i] * factor[channel]})));
    }
    for (std::size_t i = channel; i < texture->rgba.size(); i += 4) texture->rgba[i] = bytes[texture->rgba[i]];
  }
  return known = std::move(texture);
}

float ColorImages::mean(const std::shared_ptr<const Texture>& image, float leastAlpha) {
  const auto [at, isNew] = means_.emplace(std::pair{image, leastAlpha}, 0.0f);
  if (isNew) at->second = meanLuminance(*image, leastAlpha);
  return at->second;
}

std::shared_ptr<const Texture> ColorImages::find(const std::string& name, bool onlyAlpha,
                                                 const std::function<std::shared_ptr<const Texture>()>& embedded) {
  const auto broken = [&](const InputError& e) {
    warn(fmt::format("{}: the texture '{}' cannot be used: {}", asset_.string(), name, e.what()));
    return nullptr;
  };
  std::shared_ptr<const Texture> texture;
  try {
    if (embedded) texture = embedded();
  } catch (const InputLimitError&) {
    throw;
  } catch (const InputError& e) {
    return broken(e);
  }
  if (texture == nullptr) {
    const std::filesystem::path path = findTexture(asset_, name, allowOutside_, folders_);
    if (path.empty()) {
      missing_.insert(name);
      return nullptr;
    }
    if (onlyAlpha && !mayHaveAlpha(path)) return nullptr;
    try {
      texture = loadTexture(path);
    } catch (const InputLimitError&) {
      throw;
    } catch (const InputError& e) {
      return broken(e);
    }
  }
  return onlyAlpha && !texture->hasAlpha ? nullptr : texture;
}

std::vector<Look> readMaterials(const ImportedFile& imported, const std::filesystem::path& file,
                                const AssetOptions& options, LeftOut& leftOut) {
  MaterialReader reader(imported, file, options);
  std::vector<Look> materials;
  for (std::uint32_t i = 0; i < imported.materials.size(); ++i) materials.push_back(reader.read(i, leftOut));
  return materials;
}

}  // namespace scanmill
