#include "assets/meshes/base_color.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <iterator>
#include <string_view>
#include <vector>

#include "assets/meshes/references.h"
#include "base/error.h"
#include "base/input_budget.h"
#include "config/text.h"
#include "images/images.h"
#include "images/srgb.h"
#include "scene/texture.h"

namespace scanmill {

namespace {

// True for kinds of images that have no alpha.
bool isOpaqueKind(const std::string& name) {
  const std::string kind = lowerExtension(name);
  return kind == ".jpg" || kind == ".jpeg" || kind == ".bmp";
}

}  // namespace

void setColor(Material& material, BaseColor color, const std::filesystem::path& file, const AssetOptions& options,
              ColorImages& images) {
  const auto& [r, g, b] = color.factor;
  const float plain = 0.2126f * r + 0.7152f * g + 0.0722f * b;  // luminance of the factor (Rec. 709, linear)
  const bool tested = color.alpha.wanted && color.image && color.image->hasAlpha;
  if (color.colored) {
    material.textureMean = images.mean(color.image, tested ? color.alpha.cutoff : 0.0f);
    material.reflectance = material.textureMean * (color.tints ? plain : 1.0f);
  } else {
    material.reflectance = plain;
  }
  material.textured = color.colored && options.textures;
  material.alphaTested = tested;
  material.alphaCutoff = tested ? color.alpha.cutoff : 0.5f;
  if (tested || material.textured) material.texture = std::move(color.image);
  const bool untold = !color.colored && color.textured && r == 1 && g == 1 && b == 1;
  if (!untold && (color.stated || color.textured)) return;
  const Material fallback;
  material.reflectance = fallback.reflectance;
  material.metallic = fallback.metallic;
  material.source = "default: " + file.filename().string() + " has no colour";
}

ColorImages::~ColorImages() {
  const auto tell = [&](const std::set<std::string>& names, std::string_view alsoSolid) {
    constexpr std::size_t kMost = 8;
    if (names.empty()) return;
    const std::vector<std::string> first(names.begin(), std::next(names.begin(), std::min(names.size(), kMost)));
    warn(
        fmt::format("{}: missing textures: '{}'{}; plain colours replace them{}; `textures` of the "
                    "object names further folders",
                    asset_.string(), fmt::join(first, "', '"),
                    names.size() > kMost ? fmt::format(" and {} more", names.size() - kMost) : "", alsoSolid));
  };
  tell(missing_, "");
  tell(missingCutOuts_, ", and surfaces that their alpha would cut out are solid");
}

std::shared_ptr<const Texture> ColorImages::load(const std::string& key, const std::string& name, bool onlyAlpha,
                                                 bool cutsOut,
                                                 const std::function<std::shared_ptr<const Texture>()>& embedded) {
  const auto known = images_.find({key, onlyAlpha});
  if (known != images_.end()) return known->second;
  return images_[{key, onlyAlpha}] = find(name, onlyAlpha, cutsOut, embedded);
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

std::shared_ptr<const Texture> ColorImages::find(const std::string& name, bool onlyAlpha, bool cutsOut,
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
      (cutsOut && !isOpaqueKind(name) ? missingCutOuts_ : missing_).insert(name);
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

}  // namespace scanmill
