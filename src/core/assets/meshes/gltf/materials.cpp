#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>

#include "assets/meshes/base_color.h"
#include "assets/meshes/gltf/data.h"
#include "assets/meshes/references.h"
#include "base/error.h"
#include "scene/texture.h"

namespace scanmill::gltf {
namespace {

// Returns the name of an image for rules: its file; for an embedded image its name, or "*" and its number.
std::string labelOf(const Model& model, Index image) {
  const Image& i = model.images[image];
  if (!i.uri.empty() && !i.uri.starts_with("data:")) return i.uri;
  return i.name.empty() ? fmt::format("*{}", image) : i.name;
}

std::shared_ptr<const Texture> load(const Model& model, const Data& data, Index image, bool onlyAlpha, bool cutsOut,
                                    ColorImages& images) {
  const Image& i = model.images[image];
  const std::string label = labelOf(model, image);
  return images.load(std::to_string(image), label, onlyAlpha, cutsOut, [&]() -> std::shared_ptr<const Texture> {
    const std::string place = model.file.string() + ": " + label;
    if (i.view) return decodeTexture(data.view(*i.view), place);
    if (i.uri.starts_with("data:")) return decodeTexture(data.embedded(i.uri, label), place);
    return nullptr;
  });
}

AlphaTest alphaOf(const Material& m, const AssetOptions& options) {
  if (options.alpha == AlphaUse::Ignore) return {};
  const bool asked = options.alpha == AlphaUse::Test;
  if (m.alpha != Material::Alpha::Mask) return {asked || m.alpha == Material::Alpha::Blend, 0.5f};
  // glTF compares the cutoff with the product of the colour factor's alpha and the texture's alpha.
  const double factor = fraction(m.color[3], 1.0);
  if (factor > 0 && std::isfinite(m.cutoff)) return {true, static_cast<float>(m.cutoff / factor)};
  constexpr float kAboveAll = 2;
  return {true, m.cutoff > 0 ? kAboveAll : 0.0f};
}

// True if most of the image's alpha is neither near 0 nor near 1, so that a test of alpha removes or keeps what fades.
bool fades(const Texture& image) {
  std::size_t graded = 0;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) graded += image.rgba[i] >= 26 && image.rgba[i] < 230 ? 1 : 0;
  return graded > image.rgba.size() / 8;
}

ReadMaterial read(const Model& model, const Data& data, const Material* m, const AssetOptions& options,
                  ColorImages& images) {
  static const Material kDefault;
  const Material& from = m == nullptr ? kDefault : *m;
  ReadMaterial to;
  to.leftOut = from.leftOut;
  to.material = to.fileMaterial.name = from.name;
  to.fileMaterial.source = "base colour of " + model.file.filename().string();
  to.fileMaterial.roughness = static_cast<float>(fraction(from.roughness, 1.0));
  to.fileMaterial.metallic = static_cast<float>(fraction(from.metallic, 0.0));
  BaseColor color;
  for (std::size_t c = 0; c < 3; ++c) color.factor[c] = static_cast<float>(fraction(from.color[c], 1.0));
  to.color = color.factor;
  color.alpha = alphaOf(from, options);
  color.tints = true;
  color.stated = m != nullptr;
  if (from.texture) {
    to.placed = from.texture;
    to.texture = labelOf(model, from.texture->image);
    color.textured = true;
    if (options.textures || color.alpha.wanted) {
      color.image = load(model, data, from.texture->image, !options.textures, color.alpha.wanted, images);
      color.colored = color.image != nullptr;
    }
  }
  if (color.colored && (color.factor[1] != color.factor[0] || color.factor[2] != color.factor[0])) {
    // The image takes the factor's hue, and its largest channel remains: in 8 bits, dark factors would lose steps.
    const float most = *std::max_element(color.factor.begin(), color.factor.end());
    std::array<float, 3> hue = color.factor;
    for (float& channel : hue) channel /= most;
    color.image = images.tinted(color.image, hue);
    color.factor = {most, most, most};
    if (options.textures) to.color = color.factor;
  }
  const bool blends = from.alpha == Material::Alpha::Blend && options.alpha == AlphaUse::Auto;
  if (blends && color.colored && color.image->hasAlpha && fades(*color.image)) {
    to.leftOut.add("images that fade (beams pass where alpha is below 0.5)");
  }
  setColor(to.fileMaterial, std::move(color), model.file, options, images);
  const bool faded =
      from.alpha == Material::Alpha::Blend
          ? from.color[3] < 1
          : from.alpha == Material::Alpha::Mask && from.color[3] < from.cutoff && !to.fileMaterial.alphaTested;
  if (faded && options.alpha != AlphaUse::Ignore) to.leftOut.add("opacities of materials (they are solid)");
  return to;
}

}  // namespace

std::vector<ReadMaterial> readMaterials(const Model& model, const Data& data, const AssetOptions& options) {
  ColorImages images(model.file, options.allowOutside, options.textureFolders);
  std::vector<ReadMaterial> materials;
  materials.reserve(model.materials.size() + 1);
  for (const Material& m : model.materials) materials.push_back(read(model, data, &m, options, images));
  materials.push_back(read(model, data, nullptr, options, images));
  return materials;
}

}  // namespace scanmill::gltf
