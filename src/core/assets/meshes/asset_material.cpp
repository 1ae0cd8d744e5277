#include "assets/meshes/asset_material.h"

#include <memory>
#include <utility>

#include "assets/meshes/asset_alpha.h"
#include "assets/meshes/base_color.h"
#include "scene/texture.h"

namespace scanmill {

namespace {

// Reads the materials of one file.
class MaterialReader {
 public:
  MaterialReader(const ImportedFile& imported, const std::filesystem::path& file, const AssetOptions& options)
      : imported_(imported),
        file_(file),
        options_(options),
        images_(file, options.allowOutside, options.textureFolders) {}

  AssetMaterial read(std::uint32_t index, LeftOut& leftOut) {
    ImportedMaterial from = imported_.materials[index];
    for (ImportedMap* const map : {&from.base, &from.opacityMap}) {
      if (map->name == "(null)") *map = {};  // exporters print a missing name so
    }
    AssetMaterial read;
    read.material.name = from.name;
    read.material.source = "base colour of " + file_.filename().string();
    read.material.roughness = from.roughness;
    read.material.metallic = from.metallic;
    read.texture = from.base.label;

    BaseColor color;
    color.factor = from.color;
    color.stated = from.stated;
    color.textured = !from.base.name.empty();
    bool declared = false;
    color.alpha = alphaTest(from, declared);
    if (color.textured && (options_.textures || color.alpha.wanted)) {
      color.image = load(from.base, !options_.textures, color.alpha.wanted);
    }
    if (color.image && color.alpha.wanted && !declared && !isCutOut(measureAlpha(imported_, index, *color.image))) {
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
      if (const auto mask = load(opacity, false, true))
        color.image = withOpacity(color.image.get(), *mask, opacity.inverted);
    }
    if (color.alpha.wanted && opacity.name == from.base.name && color.image && !color.image->hasAlpha) {
      leftOut.add("opacity maps that are the image of the colour too, and have no alpha");
    }
    setColor(read.material, std::move(color), file_, options_, images_);
    if (from.opacity < 1 && !read.material.alphaTested && options_.alpha != AlphaUse::Ignore) {
      leftOut.add("opacities of materials (they are solid)");
    }
    return read;
  }

 private:
  // Returns the alpha test. `declared` becomes true if the test applies without a check by isCutOut().
  AlphaTest alphaTest(const ImportedMaterial& from, bool& declared) const {
    if (options_.alpha == AlphaUse::Ignore) return {};
    // An opacity of 0 would hide the material. It comes from exporters that confuse opacity with transparency, and is
    // ignored.
    declared =
        options_.alpha == AlphaUse::Test || !from.opacityMap.name.empty() || (from.opacity > 0 && from.opacity < 1);
    return {true, 0.5f};
  }

  std::shared_ptr<const Texture> load(const ImportedMap& map, bool onlyAlpha, bool cutsOut) {
    return images_.load(map.name, map.label, onlyAlpha, cutsOut, [&]() -> std::shared_ptr<const Texture> {
      if (map.embedded < 0) return nullptr;
      const ImportedImage& image = imported_.images.at(static_cast<std::size_t>(map.embedded));
      const std::string name = file_.string() + ": " + map.label;
      return image.height == 0 ? decodeTexture(image.bytes, name)
                               : plainTexture(image.bytes, image.width, image.height, name);
    });
  }

  const ImportedFile& imported_;
  const std::filesystem::path& file_;
  const AssetOptions& options_;
  ColorImages images_;
};

}  // namespace

std::vector<AssetMaterial> readMaterials(const ImportedFile& imported, const std::filesystem::path& file,
                                         const AssetOptions& options, LeftOut& leftOut) {
  MaterialReader reader(imported, file, options);
  std::vector<AssetMaterial> materials;
  for (std::uint32_t i = 0; i < imported.materials.size(); ++i) materials.push_back(reader.read(i, leftOut));
  return materials;
}

}  // namespace scanmill
