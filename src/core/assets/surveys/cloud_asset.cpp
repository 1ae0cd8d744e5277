#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "assets/meshes/asset_parts.h"
#include "assets/meshes/base_color.h"
#include "assets/surveys/surveys.h"
#include "base/error.h"
#include "base/short_text.h"
#include "config/text.h"
#include "formats/cloud_file.h"
#include "formats/readers.h"
#include "images/srgb.h"
#include "scene/texture.h"

namespace scanmill {
namespace {

constexpr std::size_t kMostPoints = 100'000'000;

class CloudAsset {
 public:
  CloudAsset(const std::filesystem::path& file, const AssetOptions& options)
      : file_(file),
        options_(options),
        cloud_(readCloud(file, options.unitStated ? CloudUnit::Metre : CloudUnit::OfFile)),
        scan_(cloud_.scan) {}

  Asset build() {
    const bool isLas = lowerExtension(file_) == ".las";
    asset_.up = options_.up.value_or('z');
    asset_.upDeclared = isLas || options_.up.has_value();
    asset_.statedUnit = isLas ? 1 : 0;
    const Mat3 frame = assetFromFile(asset_.up, options_.metresPerUnit);
    dropMisses();
    applyPose();
    choosePoints();
    for (const std::size_t i : chosen_) {
      positions_.push_back(static_cast<Vec3f>(frame * Vec3d(scan_.position[i])));
    }
    thin();
    if (positions_.size() > kMostPoints) {
      fail(fmt::format("has {} points, but at most {} can be read: give `spacing` to thin them out", positions_.size(),
                       kMostPoints));
    }
    asset_.origin = frame * cloud_.origin;
    asset_.system = cloud_.system;
    readNormals(frame * toMatrix(cloud_.worldFromFile.rotation));
    makeTexture();
    addParts();
    warnOfUnused();
    return std::move(asset_);
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const { throw InputError({file_.string()}, problem); }

  // If several points are at exactly [0, 0, 0] in the file, sets them to NaN: organised scans store misses this way.
  void dropMisses() {
    std::vector<Vec3f*> misses;
    for (Vec3f& p : cloud_.scan.position) {
      if (cloud_.origin + Vec3d(p) == Vec3d{}) misses.push_back(&p);
    }
    if (misses.size() < 2) return;
    cloud_.leftOut.add("points at 0, 0, 0, which are misses", misses.size());
    for (Vec3f* const p : misses) *p = {NAN, NAN, NAN};
  }

  void applyPose() {
    if (cloud_.worldFromFile == Pose{}) return;
    std::vector<Vec3d> positions;
    for (const Vec3f& p : scan_.position) positions.push_back(cloud_.worldFromFile * (cloud_.origin + Vec3d(p)));
    setPositions(positions, cloud_);
  }

  // Chooses the points with finite positions. Leaves out points whose class is called noise unless the option `labels`
  // is set.
  void choosePoints() {
    const auto& labels = scan_[kLabel];
    if (labels.empty() && !options_.points.labels.empty()) {
      fail(fmt::format("has no labels (a column `label`, or LAS classes), but {}{}: leave out `labels`",
                       fmt::join(columnNames(scan_), ", "),
                       cloud_.leftOut.empty() ? "" : "; left out: " + cloud_.leftOut.text()));
    }
    std::set<std::uint32_t> noiseLabels;
    for (const auto& [label, name] : cloud_.classNames) {
      const bool isNoise = options_.points.labels.empty() && lowerCase(name).find("noise") != std::string::npos;
      if (isNoise) noiseLabels.insert(label);
    }
    std::uint64_t noisePoints = 0;
    for (std::size_t i = 0; i < scan_.size(); ++i) {
      if (!isFinite(scan_.position[i])) continue;
      if (!noiseLabels.empty() && noiseLabels.contains(labels[i])) {
        ++noisePoints;
      } else {
        chosen_.push_back(i);
      }
    }
    cloud_.leftOut.add("points of classes of noise", noisePoints);
    if (chosen_.empty()) {
      fail("has no points" + (cloud_.leftOut.empty() ? "" : " but those left out: " + cloud_.leftOut.text()));
    }
  }

  // If the options state a spacing, keeps only the chosen points that thinned() returns.
  void thin() {
    if (options_.points.spacing <= 0) return;
    std::size_t count = 0;
    for (const std::size_t k : thinned(positions_, options_.points.spacing)) {  // ascending
      chosen_[count] = chosen_[k];
      positions_[count++] = positions_[k];
    }
    chosen_.resize(count);
    positions_.resize(count);
  }

  // Returns the foreign column that means `name`, whatever the file calls it; null if there is none.
  const ForeignColumn* foreign(std::string_view name) const {
    const auto meaning = [](const ForeignColumn& column) { return columnMeant(column.name); };
    const auto column = std::ranges::find(scan_.foreign, name, meaning);
    return column == scan_.foreign.end() ? nullptr : &*column;
  }

  // Warns of what the reader left out, and of foreign columns that are not used.
  void warnOfUnused() {
    constexpr std::size_t kMostNames = 8;
    std::vector<std::string> names;
    for (const ForeignColumn& column : scan_.foreign) {
      const std::string meaning = columnMeant(column.name);
      const bool isKnown = kCloudColumns.useOf(meaning) != FormatSupport::Use::Unknown;
      const bool isUsed = meaning == kIntensity.row.name && !scan_.has(kIntensity);
      if (!isKnown || (columnIndex(meaning) < kColumnCount && !isUsed)) names.push_back(column.name);
    }
    const std::size_t columns = names.size();
    if (columns > kMostNames) {
      names.resize(kMostNames);
      names.emplace_back("...");
    }
    cloud_.leftOut.add(fmt::format("columns ({})", fmt::join(names, ", ")), columns);
    cloud_.leftOut.warn(file_.string());
    if (foreign("cosangle") != nullptr) {
      warn("{}: if CARLA wrote it, its y axis points to the right, so that the place is mirrored: negate y in the file",
           file_.string());
    }
  }

  // Returns the values of the chosen points in a foreign column; nullopt if there is no column of this name.
  std::optional<std::vector<double>> numbers(std::string_view name) const {
    const ForeignColumn* const column = foreign(name);
    if (column == nullptr) return std::nullopt;
    std::vector<double> values;
    const auto copyChosen = [&](const auto& numbers) {
      for (const std::size_t i : chosen_) values.push_back(static_cast<double>(numbers[i]));
    };
    std::visit(copyChosen, column->values);
    return values;
  }

  // Fills normals_ with unit normals in the asset's frame; zero for unknown ones. Does nothing if the file has none.
  void readNormals(const Mat3& assetFromNormals) {
    const auto x = numbers("nx"), y = numbers("ny"), z = numbers("nz");
    if (!x || !y || !z) return;
    for (std::size_t k = 0; k < chosen_.size(); ++k) {
      const Vec3d n = assetFromNormals * Vec3d{(*x)[k], (*y)[k], (*z)[k]};
      normals_.push_back(length(n) > 0 ? static_cast<Vec3f>(normalized(n)) : Vec3f{});
    }
  }

  // Guesses the intensity that means a reflectance of 1: 1 if intensities are at most 1, 255 if they are at most 255,
  // else the greatest intensity. Ignores outliers above four times the 99.9th percentile (chosen by eye). `greatest`:
  // the greatest intensity of all points, outliers included.
  double guessedFullIntensity(double greatest) const {
    constexpr std::size_t kSamples = 1'000'000;
    constexpr double kPercentile = 0.999, kOutlierFactor = 4;
    const auto& intensity = scan_[kIntensity];
    std::vector<float> samples;
    for (std::size_t k = 0; k < chosen_.size(); k += 1 + chosen_.size() / kSamples) {
      if (std::isfinite(intensity[chosen_[k]])) samples.push_back(intensity[chosen_[k]]);
    }
    if (greatest <= 1 || samples.empty()) return 1;
    const auto rank = static_cast<std::ptrdiff_t>(kPercentile * static_cast<double>(samples.size() - 1));
    std::ranges::nth_element(samples, samples.begin() + rank);
    const double percentile = double{samples[static_cast<std::size_t>(rank)]};
    const bool areIntegers = std::ranges::all_of(samples, [](float value) { return value == std::floor(value); });
    if (percentile <= 1 && !areIntegers) return 1;
    const double limit = percentile > 0 ? kOutlierFactor * percentile : greatest;
    double full = 255;
    for (const std::size_t i : chosen_) {
      if (double{intensity[i]} <= limit) full = std::max(full, double{intensity[i]});
    }
    return full;
  }

  // Warns if intensities are clipped, or if the greatest one is so far below `full` that all points are dark.
  void warnOfIntensities(double full, double greatest) const {
    constexpr double kLeastFraction = 0.05;  // least ratio of the greatest intensity to `full`
    std::size_t above = 0, below = 0, missing = 0;
    for (const std::size_t i : chosen_) {
      const double value = double{scan_[kIntensity][i]};
      above += value > full ? 1u : 0u;
      below += value < 0 ? 1u : 0u;
      missing += std::isnan(value) ? 1u : 0u;
    }
    if (above + below + missing == 0 && greatest >= kLeastFraction * full) return;
    warn(
        "{}: the intensity {} is taken as a reflectance of 1: {} of {} points are above it and are clipped "
        "to it (the greatest is {}), {} are below 0 and {} are no numbers, which count as 0; state another "
        "by `points: {{full: ...}}`",
        file_.string(), full, grouped(above), grouped(chosen_.size()), greatest, grouped(below), grouped(missing));
  }

  // Makes a texture with one texel per point, which shows the intensity as a grey, or else the colour. Makes no texture
  // if the options exclude both, or if the file has neither.
  void makeTexture() {
    auto image = std::make_shared<Texture>();
    image->file = file_.string();
    image->width = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(chosen_.size()))));
    image->height = static_cast<std::uint32_t>((chosen_.size() + image->width - 1) / image->width);
    image->rgba.assign(std::size_t{image->width} * image->height * 4, 255);
    if (!fill(*image)) return;
    // Copies of the first texels fill the last row, so that the mean of the texture hardly changes.
    const std::size_t filledBytes = 4 * chosen_.size();
    std::copy_n(image->rgba.begin(), image->rgba.size() - filledBytes,
                image->rgba.begin() + std::ptrdiff_t(filledBytes));
    image_ = std::move(image);
  }

  // Fills the texture from the intensities or the colours, as the options demand. Returns false if it fills nothing.
  bool fill(Texture& image) {
    using enum PointOptions::Reflectance;
    const PointOptions::Reflectance source = options_.points.reflectance;
    showsIntensities_ = (source == Auto || source == Intensity) && fillWithIntensities(image);
    if (showsIntensities_) return true;
    if (source == Intensity) fail("has no intensities above 0: leave out `reflectance: intensity`");
    if (source != None && fillWithColors(image)) return true;
    if (source == Color) fail("has no colours (red, green, blue; or rgb): leave out `reflectance: color`");
    return false;
  }

  // Fills the texture with the intensities of the points as greys. Returns false if no intensity is above 0.
  bool fillWithIntensities(Texture& image) {
    const auto& intensity = scan_[kIntensity];
    if (intensity.empty()) return false;
    double greatest = 0, least = 0;
    for (const std::size_t i : chosen_) {
      greatest = std::max(greatest, double{intensity[i]});
      least = std::min(least, double{intensity[i]});
    }
    if (greatest == 0 && least < 0) cloud_.leftOut.add("intensities, none of which is above 0", chosen_.size());
    if (greatest == 0) return false;
    const double full = options_.points.full > 0 ? options_.points.full : guessedFullIntensity(greatest);
    if (options_.points.full == 0) warnOfIntensities(full, greatest);
    for (std::size_t k = 0; k < chosen_.size(); ++k) {
      // NaN becomes 0: std::max() returns its first argument if the second is NaN.
      const double value = std::min(std::max(0.0, double{intensity[chosen_[k]]} / full), 1.0);
      const auto grey = static_cast<std::uint8_t>(std::lround(255 * srgbOf(value)));
      std::fill_n(image.rgba.begin() + static_cast<std::ptrdiff_t>(4 * k), 3, grey);
    }
    return true;
  }

  // Returns the packed red, green and blue of a value: the Point Cloud Library stores the bits of an integer as a
  // float, other programs store the integer. Returns nullopt for the NaN that text files state.
  template <class T>
  static std::optional<std::uint32_t> packedColor(T value) {
    constexpr std::uint32_t kNan = 0x7FC00000;  // other NaNs are colours with an alpha of 255
    if constexpr (std::is_floating_point_v<T>) {
      // The bits of a colour with alpha 0 or 255, read as a float, are below 1 in magnitude or outside of these limits.
      constexpr double kGreatest = std::numeric_limits<std::uint32_t>::max();
      constexpr double kLeast = std::numeric_limits<std::int32_t>::min();
      const bool isInteger = std::fabs(value) >= 1 && double{value} <= kGreatest && double{value} >= kLeast;
      const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
      if (!isInteger) return bits == kNan ? std::nullopt : std::optional(bits);
    }
    return static_cast<std::uint32_t>(static_cast<std::int64_t>(value));
  }

  // Fills the texture with the colours of the points. Returns false if no point has a colour.
  bool fillWithColors(Texture& image) {
    const ForeignColumn* const packed = foreign("rgb");
    const std::optional<std::size_t> colored =
        packed != nullptr ? fillFromPacked(*packed, image) : fillFromChannels(image);
    if (!colored) return false;
    cloud_.leftOut.add("colours that are no numbers", chosen_.size() - *colored);
    return *colored > 0;
  }

  // Fills the texture from a column of packed colours. Returns the number of points that have a colour.
  std::size_t fillFromPacked(const ForeignColumn& packed, Texture& image) const {
    std::size_t colored = 0;
    const auto fillFrom = [&](const auto& numbers) {
      for (std::size_t k = 0; k < chosen_.size(); ++k) {
        const auto bits = packedColor(numbers[chosen_[k]]);  // 0xAARRGGBB
        std::array<double, 3> color{NAN, NAN, NAN};
        if (bits) color = {double(*bits >> 16 & 0xFF), double(*bits >> 8 & 0xFF), double(*bits & 0xFF)};
        colored += putColor(color, k, image) ? 1 : 0;
      }
    };
    std::visit(fillFrom, packed.values);
    return colored;
  }

  // Fills the texture from the columns red, green and blue. Returns the number of points that have a colour; nullopt if
  // a column is missing, or if all values are 0, as in LAS files without colours.
  std::optional<std::size_t> fillFromChannels(Texture& image) const {
    const std::array<std::optional<std::vector<double>>, 3> channels{numbers("red"), numbers("green"), numbers("blue")};
    if (!channels[0] || !channels[1] || !channels[2]) return std::nullopt;
    double greatest = 0;
    bool areIntegers = true;
    for (const auto& channel : channels) {
      for (const double value : *channel) {
        greatest = std::max(greatest, value);
        areIntegers = areIntegers && (value == std::floor(value) || std::isnan(value));
      }
    }
    if (!(greatest > 0)) return std::nullopt;
    const double white = whiteOf(greatest, areIntegers);
    std::size_t colored = 0;
    for (std::size_t k = 0; k < chosen_.size(); ++k) {
      const auto channel = [&](std::size_t c) { return 255 * (*channels[c])[k] / white; };
      colored += putColor({channel(0), channel(1), channel(2)}, k, image) ? 1 : 0;
    }
    return colored;
  }

  // Stores the colour (0 to 255) of the chosen point k. If a channel is NaN, stores black and returns false.
  static bool putColor(const std::array<double, 3>& color, std::size_t k, Texture& image) {
    const bool isStated = std::ranges::none_of(color, [](double channel) { return std::isnan(channel); });
    for (std::size_t c = 0; c < 3; ++c) {
      const double channel = isStated ? std::clamp(color[c], 0.0, 255.0) : 0.0;
      image.rgba[4 * k + c] = static_cast<std::uint8_t>(std::lround(channel));
    }
    return isStated;
  }

  // Returns the value that means white: 1, 255 or 65535. In float columns with values of at most 1, white is 1, even if
  // all values are 0 or 1 (text files are read as floats, too). Rounding can lift fractions slightly above 1.
  double whiteOf(double greatest, bool areIntegers) const {
    const bool areFloats =
        std::visit([]<class T>(const std::vector<T>&) { return std::is_floating_point_v<T>; }, foreign("red")->values);
    if (areFloats && (greatest <= 1 || (greatest < 2 && !areIntegers))) return 1;
    if (greatest < 256) return 255;
    constexpr double kWhite = 65535;
    if (greatest < kWhite / 4) {
      warn("{}: its greatest colour is {}, but {} is taken as white: scale the colours in the file to 8 or 16 bits",
           file_.string(), greatest, kWhite);
    }
    return kWhite;
  }

  std::string nameOf(std::uint32_t label) const {
    for (const auto* names : {&options_.points.labels, &cloud_.classNames}) {
      if (names->contains(label)) return names->at(label);
    }
    return fmt::format("{}", label);
  }

  // Adds the points as squares to the parts of their instances and labels.
  void addParts() {
    const std::vector<Surfel> surfels = surfelsOf(positions_, normals_, options_.points.surfels);
    const auto& labels = scan_[kLabel];
    const auto& instances = scan_[kInstance];
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> partOf;  // index, by instance and label
    std::map<std::uint32_t, std::pair<double, double>> sums;  // sum of the reflectances and number of points, by label
    for (std::size_t k = 0; k < chosen_.size(); ++k) {
      const std::uint32_t label = labels.empty() ? 0 : labels[chosen_[k]];
      const std::uint32_t instance = instances.empty() ? 0 : instances[chosen_[k]];
      const auto [part, isNew] = partOf.try_emplace({instance, label}, asset_.parts.size());
      if (isNew) asset_.parts.push_back(newPart(label, instance));
      addSquare(asset_.parts[part->second], k, surfels[k]);
      if (image_ == nullptr) continue;
      sums[label].first += double{luminance(&image_->rgba[4 * k])};
      ++sums[label].second;
    }
    if (image_ == nullptr) return;
    // Each point keeps its own reflectance. The material of a label gets the mean reflectance of the label's points.
    for (const auto& [key, part] : partOf) {
      const auto& [sum, count] = sums[key.second];
      Material& material = asset_.parts[part].fileMaterial;
      material.reflectance = material.textureMean = static_cast<float>(sum / count);
    }
  }

  // Returns a part without points for a label and an instance, which are 0 if the points have none.
  AssetPart newPart(std::uint32_t label, std::uint32_t instance) {
    AssetPart part;
    part.node = instance == 0 ? "" : fmt::format("instance {}", instance);
    part.nodeIndex = nodes_.try_emplace(instance, static_cast<std::uint32_t>(nodes_.size())).first->second;
    if (!scan_[kLabel].empty()) part.material = part.ownClass = nameOf(label);
    if (image_ != nullptr) part.texture = showsIntensities_ ? kPointIntensity : kPointColor;
    part.fileMaterial.name = part.material.empty() ? "points" : part.material;
    part.fileMaterial.source = fmt::format("mean of the {} in {}; each point has its own",
                                           showsIntensities_ ? "intensities" : "colours", file_.filename().string());
    using enum BaseColor::Source;
    setColor(part.fileMaterial, {.source = image_ ? Image : None, .image = image_}, file_, options_, images_);
    return part;
  }

  // Adds the square of the chosen point k: two triangles, as large as the surfel's disc.
  void addSquare(AssetPart& part, std::size_t k, const Surfel& surfel) {
    const Vec3d normal(surfel.normal);
    const bool isAlongX = std::fabs(normal.x) >= 0.7;
    const Vec3d across = normalized(cross(isAlongX ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0}, normal));
    const double half = double{surfel.radius} * std::sqrt(kPi) / 2;  // m, half the edge of a square of the disc's area
    const Vec3d u = across * half;
    const Vec3d v = cross(normal, across) * half;
    const Vec3d middle(positions_[k]);
    const auto first = static_cast<std::uint32_t>(part.positions.size());
    for (const Vec3d& corner : {middle - u - v, middle + u - v, middle + u + v, middle - u + v}) {
      part.positions.push_back(static_cast<Vec3f>(corner));
    }
    if (image_ != nullptr) {
      const auto column = static_cast<double>(k % image_->width);
      const auto row = static_cast<double>(k / image_->width);  // NOLINT(bugprone-integer-division): a whole number
      const Vec2f uv{static_cast<float>((column + 0.5) / image_->width),
                     static_cast<float>((row + 0.5) / image_->height)};
      part.uvs.insert(part.uvs.end(), 4, uv);
    }
    part.triangles.push_back({first, first + 1, first + 2});
    part.triangles.push_back({first, first + 2, first + 3});
  }

  const std::filesystem::path& file_;
  const AssetOptions& options_;
  Cloud cloud_;
  const Scan& scan_;
  ColorImages images_{file_, true};
  std::vector<std::size_t> chosen_;  // indices of the chosen points in scan_
  std::vector<Vec3f> positions_;     // m; positions of the chosen points in the asset's axes, relative to its origin
  std::vector<Vec3f> normals_;       // normals of the chosen points, zero if unknown; empty: the file has none
  std::shared_ptr<const Texture> image_;          // a texel per chosen point; null: the points have no reflectances
  bool showsIntensities_ = false;                 // true: image_ shows intensities; false: colours
  std::map<std::uint32_t, std::uint32_t> nodes_;  // index of the node, by instance
  Asset asset_;
};

}  // namespace

Asset readCloudAsset(const std::filesystem::path& file, const AssetOptions& options) {
  return CloudAsset(file, options).build();
}

}  // namespace scanmill
