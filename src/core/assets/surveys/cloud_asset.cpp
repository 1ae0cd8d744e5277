#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "assets/asset_parts.h"
#include "assets/base_color.h"
#include "assets/surveys/surfels.h"
#include "assets/surveys/surveys.h"
#include "base/error.h"
#include "config/text.h"
#include "formats/cloud_file.h"
#include "images/srgb.h"
#include "scene/texture.h"

namespace scanmill {
namespace {

constexpr std::size_t kMostPoints = 100'000'000;
constexpr std::uint32_t kLowNoise = 7, kHighNoise = 18;  // LAS classes of noise

// Returns the name of a class from table 17 of the specification of LAS 1.4; its number if it has no name.
std::string lasClass(std::uint32_t label) {
  static constexpr std::array<const char*, 23> kNames{"never classified",
                                                      "unclassified",
                                                      "ground",
                                                      "low vegetation",
                                                      "medium vegetation",
                                                      "high vegetation",
                                                      "building",
                                                      "low noise",
                                                      "key point",
                                                      "water",
                                                      "rail",
                                                      "road surface",
                                                      "overlap",
                                                      "wire guard",
                                                      "wire conductor",
                                                      "transmission tower",
                                                      "wire connector",
                                                      "bridge deck",
                                                      "high noise",
                                                      "overhead structure",
                                                      "ignored ground",
                                                      "snow",
                                                      "temporal exclusion"};
  return label < kNames.size() ? kNames[label] : fmt::format("{}", label);
}

class CloudAsset {
 public:
  CloudAsset(const std::filesystem::path& file, const AssetOptions& options)
      : file_(file), options_(options), cloud_(readCloud(file)), scan_(cloud_.scan) {}

  Asset build() {
    asset_.up = options_.up.value_or('z');
    asset_.upDeclared = las_ || options_.up.has_value();
    const double unit = options_.metresPerUnit;
    const Mat3 assetFromFile = zUpFrom(asset_.up) * Mat3::scale({unit, unit, unit});
    choosePoints();
    for (const std::size_t i : chosen_) {
      positions_.push_back(static_cast<Vec3f>(assetFromFile * Vec3d(scan_.position[i])));
    }
    thin();
    if (positions_.size() > kMostPoints) {
      throw InputError({file_.string()},
                       fmt::format("has {} points, but at most {} can be read: give `spacing` to thin them out",
                                   positions_.size(), kMostPoints));
    }
    asset_.origin = assetFromFile * cloud_.origin;
    readNormals(assetFromFile);
    readColors();
    addParts();
    return std::move(asset_);
  }

 private:
  // Chooses the points with finite positions. Leaves out the noise of LAS files unless the option `labels` is set.
  void choosePoints() {
    const auto& labels = scan_[kLabel];
    if (labels.empty() && !options_.points.labels.empty()) {
      throw InputError({file_.string()}, "has no labels (a column `label`, or LAS classes): leave out `labels`");
    }
    const bool noisy = las_ && options_.points.labels.empty();
    for (std::size_t i = 0; i < scan_.size(); ++i) {
      if (!isFinite(scan_.position[i])) continue;
      if (noisy && (labels[i] == kLowNoise || labels[i] == kHighNoise)) continue;
      chosen_.push_back(i);
    }
    if (chosen_.empty()) throw InputError({file_.string()}, "has no points");
  }

  void thin() {
    if (options_.points.spacing <= 0) return;
    std::vector<std::size_t> left;
    std::vector<Vec3f> places;
    for (const std::size_t k : thinned(positions_, options_.points.spacing)) {
      left.push_back(chosen_[k]);
      places.push_back(positions_[k]);
    }
    chosen_ = std::move(left);
    positions_ = std::move(places);
  }

  const ForeignColumn* foreign(std::string_view name) const {
    for (const ForeignColumn& column : scan_.foreign) {
      if (column.name == name) return &column;
    }
    return nullptr;
  }

  // Returns the values of the chosen points in a foreign column; nullopt if there is no column of this name.
  std::optional<std::vector<double>> numbers(std::string_view name) const {
    const ForeignColumn* const column = foreign(name);
    if (column == nullptr) return std::nullopt;
    std::vector<double> values;
    std::visit(
        [&](const auto& all) {
          for (const std::size_t i : chosen_) values.push_back(static_cast<double>(all[i]));
        },
        column->values);
    return values;
  }

  void readNormals(const Mat3& assetFromFile) {
    for (const auto& names : {std::array{"nx", "ny", "nz"}, std::array{"normal_x", "normal_y", "normal_z"}}) {
      const auto x = numbers(names[0]);
      const auto y = numbers(names[1]);
      const auto z = numbers(names[2]);
      if (!x || !y || !z) continue;
      for (std::size_t k = 0; k < chosen_.size(); ++k) {
        const Vec3d n = assetFromFile * Vec3d{(*x)[k], (*y)[k], (*z)[k]};
        normals_.push_back(length(n) > 0 ? static_cast<Vec3f>(normalized(n)) : Vec3f{});
      }
      return;
    }
  }

  // Guesses, from the greatest intensity, which intensity means a reflectance of 1.
  static double fullOf(double greatest) {
    for (const double full : {1.0, 255.0}) {
      if (greatest <= full) return full;
    }
    return greatest;
  }

  // Makes a texture with one texel per point: the point's intensity as a grey, or its colour.
  void readColors() {
    auto image = std::make_shared<Texture>();
    image->file = file_.string();
    image->width = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(chosen_.size()))));
    image->height = static_cast<std::uint32_t>((chosen_.size() + image->width - 1) / image->width);
    image->rgba.assign(std::size_t{image->width} * image->height * 4, 255);
    if (!fill(*image)) return;
    // Fills the remaining texels of the last row with copies of the first texels, so that the mean of the texture
    // hardly changes.
    for (std::size_t at = 4 * chosen_.size(); at < image->rgba.size(); ++at) {
      image->rgba[at] = image->rgba[at - 4 * chosen_.size()];
    }
    image_ = std::move(image);
  }

  bool fill(Texture& image) {
    using Source = PointOptions::Reflectance;
    const Source wanted = options_.points.reflectance;
    const auto& intensity = scan_[kIntensity];
    if ((wanted == Source::Auto || wanted == Source::Intensity) && !intensity.empty()) {
      double greatest = 0;
      for (const std::size_t i : chosen_) greatest = std::max(greatest, double{intensity[i]});
      if (greatest > 0) {
        const double full = options_.points.full > 0 ? options_.points.full : fullOf(greatest);
        for (std::size_t k = 0; k < chosen_.size(); ++k) {
          const double value = std::clamp(double{intensity[chosen_[k]]} / full, 0.0, 1.0);
          const auto grey = static_cast<std::uint8_t>(std::lround(255 * srgbOf(value)));
          std::fill_n(image.rgba.begin() + static_cast<std::ptrdiff_t>(4 * k), 3, grey);
        }
        measured_ = true;
        return true;
      }
    }
    if (wanted == Source::Intensity) {
      throw InputError({file_.string()}, "has no intensities above 0: leave out `reflectance: intensity`");
    }
    if (wanted != Source::None && fillColors(image)) return true;
    if (wanted != Source::Color) return false;
    throw InputError({file_.string()}, "has no colours (red, green, blue; or rgb): leave out `reflectance: color`");
  }

  bool fillColors(Texture& image) const {
    const auto put = [&](std::size_t k, std::size_t channel, double value) {
      image.rgba[4 * k + channel] = static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
    };
    // The Point Cloud Library packs red, green and blue into an integer, whose bits may be stored as a float.
    if (const ForeignColumn* packed = foreign("rgb") != nullptr ? foreign("rgb") : foreign("rgba")) {
      std::visit(
          [&]<class T>(const std::vector<T>& all) {
            for (std::size_t k = 0; k < chosen_.size(); ++k) {
              std::uint32_t bits = 0;
              if constexpr (std::is_same_v<T, float>) {
                bits = std::bit_cast<std::uint32_t>(all[chosen_[k]]);
              } else {
                bits = static_cast<std::uint32_t>(static_cast<std::int64_t>(all[chosen_[k]]));
              }
              for (std::size_t c = 0; c < 3; ++c) put(k, c, bits >> (16 - 8 * c) & 0xFF);
            }
          },
          packed->values);
      return true;
    }
    const std::array<std::optional<std::vector<double>>, 3> channels{numbers("red"), numbers("green"), numbers("blue")};
    double greatest = 0;
    for (const auto& channel : channels) {
      if (!channel) return false;
      for (const double value : *channel) greatest = std::max(greatest, value);
    }
    if (!(greatest > 0)) return false;  // LAS files may have colour channels with zeroes only
    const double full = greatest <= 1 ? 1 : greatest <= 255 ? 255 : 65535;
    for (std::size_t k = 0; k < chosen_.size(); ++k) {
      for (std::size_t c = 0; c < 3; ++c) put(k, c, 255 * (*channels[c])[k] / full);
    }
    return true;
  }

  std::string nameOf(std::uint32_t label) const {
    const auto own = options_.points.labels.find(label);
    if (own != options_.points.labels.end()) return own->second;
    return las_ ? lasClass(label) : fmt::format("{}", label);
  }

  void addParts() {
    const std::vector<Surfel> surfels = surfelsOf(positions_, normals_, options_.points.surfels);
    const auto& labels = scan_[kLabel];
    const auto& instances = scan_[kInstance];
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> known;  // index of a part, by instance and label
    for (std::size_t k = 0; k < chosen_.size(); ++k) {
      const std::uint32_t label = labels.empty() ? 0 : labels[chosen_[k]];
      const std::uint32_t instance = instances.empty() ? 0 : instances[chosen_[k]];
      const auto [found, isNew] = known.try_emplace({instance, label}, asset_.parts.size());
      if (isNew) asset_.parts.push_back(newPart(label, instance, !labels.empty()));
      addSquare(asset_.parts[found->second], k, surfels[k]);
    }
  }

  AssetPart newPart(std::uint32_t label, std::uint32_t instance, bool labelled) {
    AssetPart part;
    part.node = instance == 0 ? "" : fmt::format("instance {}", instance);
    part.nodeIndex = nodes_.try_emplace(instance, static_cast<std::uint32_t>(nodes_.size())).first->second;
    if (labelled) part.material = part.ownClass = nameOf(label);
    if (image_ != nullptr) part.texture = measured_ ? kPointIntensity : kPointColor;
    part.fileMaterial.name = part.material.empty() ? "points" : part.material;
    BaseColor color;
    color.stated = false;
    color.image = image_;
    color.colored = color.textured = image_ != nullptr;
    setColor(part.fileMaterial, std::move(color), file_, options_, images_);
    return part;
  }

  void addSquare(AssetPart& part, std::size_t k, const Surfel& surfel) {
    const Vec3d normal(surfel.normal);
    const Vec3d across = normalized(cross(std::fabs(normal.x) < 0.7 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}, normal));
    const double half = double{surfel.radius} * std::sqrt(kPi) / 2;
    const Vec3d u = across * half;
    const Vec3d v = cross(normal, across) * half;
    const Vec3d middle(positions_[k]);
    const auto first = static_cast<std::uint32_t>(part.positions.size());
    for (const Vec3d& corner : {middle - u - v, middle + u - v, middle + u + v, middle - u + v}) {
      part.positions.push_back(static_cast<Vec3f>(corner));
    }
    if (image_ != nullptr) {
      const auto x = static_cast<double>(k % image_->width);
      const std::size_t row = k / image_->width;
      const auto y = static_cast<double>(row);
      const Vec2f uv{static_cast<float>((x + 0.5) / image_->width), static_cast<float>((y + 0.5) / image_->height)};
      part.uvs.insert(part.uvs.end(), 4, uv);
    }
    part.triangles.push_back({first, first + 1, first + 2});
    part.triangles.push_back({first, first + 2, first + 3});
  }

  const std::filesystem::path& file_;
  const AssetOptions& options_;
  const bool las_ = lowerExtension(file_) == ".las";
  Cloud cloud_;
  const Scan& scan_;
  ColorImages images_{file_, true};
  std::vector<std::size_t> chosen_;  // indices of the chosen points in scan_
  std::vector<Vec3f> positions_;     // m; positions of the chosen points in the asset's axes, relative to its origin
  std::vector<Vec3f> normals_;
  std::shared_ptr<const Texture> image_;
  bool measured_ = false;                         // true: image_ shows intensities; false: colours
  std::map<std::uint32_t, std::uint32_t> nodes_;  // index of the node, by instance
  Asset asset_;
};

}  // namespace

Asset readCloudAsset(const std::filesystem::path& file, const AssetOptions& options) {
  return CloudAsset(file, options).build();
}

}  // namespace scanmill
