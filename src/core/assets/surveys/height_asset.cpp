#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "assets/meshes/base_color.h"
#include "assets/surveys/surveys.h"
#include "base/earth.h"
#include "base/error.h"
#include "base/short_text.h"
#include "rasters/raster.h"

namespace scanmill {
namespace {

constexpr std::size_t kMostSamples = 64'000'000;
constexpr std::uint32_t kNew = std::numeric_limits<std::uint32_t>::max();

class HeightAsset {
 public:
  HeightAsset(const std::filesystem::path& file, const AssetOptions& options)
      : file_(file),
        options_(options),
        wanted_(options.heights),
        heights_(readRaster(file, {RasterUse::Heights, 1, wanted_.every, wanted_.within, kMostSamples})) {}

  Asset build() {
    if (options_.up && *options_.up != 'z') fail("heights are always along z: leave out `up`");
    if (heights_.width < 2 || heights_.height < 2) {
      fail("has fewer than two samples along an axis: a surface needs at least two");
    }
    asset_.up = 'z';
    asset_.upDeclared = true;
    asset_.statedUnit = 1;
    place();
    if (!wanted_.classes.empty()) readClasses();
    if (!wanted_.image.empty()) readImage();
    findPlaces(0);
    for (int row = 0; row + 1 < heights_.height; ++row) {
      findPlaces(row + 1);
      for (int column = 0; column + 1 < heights_.width; ++column) addCell(column, row);
    }
    if (beside_ > 0) {
      warn(fmt::format("{}: does not cover {} of the vertices of {}, which have the colour of its edge",
                       wanted_.image.string(), grouped(beside_), file_.string()));
    }
    if (unclassed_ > 0) {
      warn(fmt::format("{}: has no class for {} of the {} cells of {}, whose material is called 'no class'",
                       wanted_.classes.string(), grouped(unclassed_), grouped(cells_), file_.string()));
    }
    if (asset_.parts.empty()) fail("has no cell whose four samples all have heights");
    return std::move(asset_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError({file_.string()}, what); }

  std::size_t indexOf(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(heights_.width) + static_cast<std::size_t>(column);
  }

  Vec3d onEarth(double x, double y, double z) const {
    return earthCentred(radians(x * heights_.perUnit), radians(y * heights_.perUnit), z);
  }

  void place() {
    checkValues();
    const auto [x, y] = heights_.place(heights_.width / 2, heights_.height / 2);
    const double unit = options_.metresPerUnit;
    if (heights_.geographic) {
      // If the number of samples is even, the middle lies between two of them.
      const auto [x2, y2] = heights_.place((heights_.width - 1) / 2, (heights_.height - 1) / 2);
      localFromEarth_ = eastNorthUp(onEarth((x + x2) / 2, (y + y2) / 2, 0));
      asset_.ownMiddle = true;
      asset_.system = fmt::format("[{}, {}]", (x + x2) / 2, (y + y2) / 2);
      return;
    }
    if (unit == 1) asset_.system = heights_.reference;
    asset_.origin = {std::floor(x * heights_.perUnit) * unit, std::floor(y * heights_.perUnit) * unit, 0};
  }

  // Throws InputError if heights or latitudes cannot be on the earth, or if a raster without a coordinate system seems
  // to be in degrees: if degrees were read as metres, hills would become needles. Warns if one with a system does.
  void checkValues() const {
    constexpr double kHighest = 30e3;  // m; no mountain or trench, and no marker of missing samples but -9999
    constexpr double kSteepest = 3;    // largest ratio of height range to horizontal extent of a raster in metres
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const float value : heights_.values) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, double{value});
      high = std::max(high, double{value});
    }
    const double farthest = -low > high ? low : high;
    if (std::isfinite(farthest) && std::fabs(farthest) * options_.metresPerUnit > kHighest) {
      fail(
          fmt::format("has a height of {:.9g} m: if this value marks missing samples, say so by gdal_edit.py "
                      "-a_nodata; if heights are not in metres, by gdal_edit.py -units",
                      farthest));
    }
    const auto [x, y] = heights_.place(0, 0);
    const auto [x2, y2] = heights_.place(heights_.width - 1, heights_.height - 1);
    constexpr double kPole = 90 + 1e-6;  // degrees
    const double north = std::max(std::fabs(y), std::fabs(y2));
    if (heights_.geographic && north * heights_.perUnit > kPole) {
      fail(
          fmt::format("is in degrees, as its coordinate system says, but has the latitude {:.9g}: state "
                      "the system of its coordinates by gdal_edit.py -a_srs",
                      north * heights_.perUnit));
    }
    if (heights_.geographic || options_.metresPerUnit != 1) return;
    if (std::max(std::fabs(x), std::fabs(x2)) > 360 || std::max(std::fabs(y), std::fabs(y2)) > 90) return;
    const double extent = std::hypot(x2 - x, y2 - y);
    if (!(high - low > kSteepest * extent)) return;
    if (!heights_.reference.empty()) {
      warn(
          fmt::format("{}: rises by {:.4g} m within {:.4g} units of its coordinate system: if its coordinates are "
                      "degrees, say so by 'gdal_edit.py -a_srs EPSG:4326'",
                      file_.string(), high - low, extent));
      return;
    }
    fail(
        fmt::format("rises by {:.4g} m within {:.4g} metres or degrees, but has no coordinate system: put this into a "
                    ".prj file beside it, or into the file by gdal_edit.py -a_srs (degrees are EPSG:4326)",
                    high - low, extent));
  }

  // Computes the positions of a row of samples. Only the two latest rows are stored.
  void findPlaces(int row) {
    std::vector<Vec3d>& places = places_[static_cast<std::size_t>(row) % 2];
    places.resize(static_cast<std::size_t>(heights_.width));
    for (int column = 0; column < heights_.width; ++column) {
      places[static_cast<std::size_t>(column)] = vertex(column, row);
    }
  }

  // Returns the position of a sample (m), relative to the asset's origin.
  Vec3d vertex(int column, int row) const {
    const auto [x, y] = heights_.place(column, row);
    const double z = double{heights_.values[indexOf(column, row)]};
    const double unit = options_.metresPerUnit;
    if (heights_.geographic) return localFromEarth_ * onEarth(x, y, z) * unit;
    return Vec3d{x * heights_.perUnit, y * heights_.perUnit, z} * unit - asset_.origin;
  }

  void expectSame(const Raster& other, const std::filesystem::path& name) const {
    if (sameReference(heights_, other)) return;
    throw InputError(
        {name.string()},
        fmt::format("has another coordinate system than {}: convert it by `gdalwarp -t_srs`", file_.string()));
  }

  void readClasses() {
    classes_ = readRaster(wanted_.classes, {RasterUse::Classes, 1, 1, boundsOfHeights(), kMostSamples});
    expectSame(*classes_, wanted_.classes);
    const auto isPart = [](float value) { return std::isfinite(value) && value != std::round(value); };
    const auto part = std::find_if(classes_->values.begin(), classes_->values.end(), isPart);
    if (part == classes_->values.end()) return;
    throw InputError(
        {wanted_.classes.string()},
        fmt::format(
            "has {} samples that are no whole numbers, such as {:.6g}, but classes are: resample it "
            "by `gdalwarp -r near`, and leave out scale and offset by `gdal_translate -a_scale 1 "
            "-a_offset 0`",
            grouped(static_cast<std::size_t>(std::count_if(classes_->values.begin(), classes_->values.end(), isPart))),
            *part));
  }

  // Returns the x and y bounds of the height samples, extended by one sample on each side.
  RasterBounds boundsOfHeights() const {
    RasterBounds b{INFINITY, INFINITY, -INFINITY, -INFINITY};
    for (const int column : {-1, heights_.width}) {
      for (const int row : {-1, heights_.height}) {
        const auto [x, y] = heights_.place(column, row);
        b = {std::min(b[0], x), std::min(b[1], y), std::max(b[2], x), std::max(b[3], y)};
      }
    }
    return b;
  }

  void readImage() {
    const std::filesystem::path& file = wanted_.image;
    const std::array<int, 3> bands = colorBands(file);
    std::array<std::vector<float>, 3> channels;
    double greatest = 0;
    bool whole = true;  // all values are whole numbers
    for (std::size_t k = 0; k < 3; ++k) {
      if (k > 0 && bands[k] == bands[0]) continue;
      photo_ = readRaster(file, {RasterUse::Colors, bands[k], 1, boundsOfHeights(), kMostSamples});
      channels[k] = std::move(photo_.values);
      for (const float value : channels[k]) {
        if (!std::isfinite(value)) continue;
        greatest = std::max(greatest, double{value});
        whole = whole && value == std::floor(value);
      }
    }
    expectSame(photo_, file);
    // The greatest value of all bands shows which value is white.
    const double white = greatest > 255 ? 65535 : greatest > 1 || whole ? 255 : 1;
    if (greatest > 255 && (greatest < white / 4 || greatest > white)) {
      warn(
          fmt::format("{}: its brightest value is {:.6g}, but white is 65535 in an image of more than 8 bits: scale it "
                      "by 'gdal_translate -ot Byte -scale'",
                      file.string(), greatest));
    }
    auto image = std::make_shared<Texture>();
    image->file = file.string();
    image->width = static_cast<std::uint32_t>(photo_.width);
    image->height = static_cast<std::uint32_t>(photo_.height);
    image->rgba.resize(channels[0].size() * 4, 255);
    std::size_t black = 0;
    for (std::size_t i = 0; i < channels[0].size(); ++i) {
      // The first row of a texture is the image's bottom.
      const std::size_t row = i / image->width;
      std::uint8_t* const to = &image->rgba[4 * ((image->height - 1 - row) * image->width + i % image->width)];
      bool missing = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto value = double{channels[channels[k].empty() ? 0 : k][i]};
        missing = missing && !std::isfinite(value);
        to[k] = static_cast<std::uint8_t>(
            std::lround(std::isfinite(value) ? std::clamp(value * 255 / white, 0.0, 255.0) : 0));
      }
      black += missing ? 1 : 0;
    }
    if (black > 0) warn(fmt::format("{}: {} samples have no colour and count as black", file.string(), grouped(black)));
    image_ = std::move(image);
  }

  void addCell(int column, int row) {
    const std::array<std::array<int, 2>, 4> at{
        {{column, row}, {column, row + 1}, {column + 1, row + 1}, {column + 1, row}}};
    std::array<Vec3d, 4> corner;
    for (std::size_t k = 0; k < 4; ++k) {
      if (!std::isfinite(heights_.values[indexOf(at[k][0], at[k][1])])) return;
      corner[k] = places_[static_cast<std::size_t>(at[k][1]) % 2][static_cast<std::size_t>(at[k][0])];
    }
    const auto [x, y] = heights_.place(column, row);
    const auto [x2, y2] = heights_.place(column + 1, row + 1);
    const float own = classes_ ? classes_->at((x + x2) / 2, (y + y2) / 2) : 0;
    ++cells_;
    unclassed_ += std::isfinite(own) ? 0 : 1;
    Part& part = partOf(own);
    std::array<std::uint32_t, 4> v{};
    for (std::size_t k = 0; k < 4; ++k) v[k] = vertexOf(part, at[k][0], at[k][1], corner[k]);
    // Triangles must face up, whatever the directions of rows and columns.
    const bool turned = cross(corner[1] - corner[0], corner[2] - corner[0]).z < 0;
    const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
      asset_.parts[part.index].triangles.push_back(turned ? Triangle{v[a], v[c], v[b]} : Triangle{v[a], v[b], v[c]});
    };
    if (length(corner[2] - corner[0]) <= length(corner[3] - corner[1])) {
      add(0, 1, 2);
      add(0, 2, 3);
    } else {
      add(0, 1, 3);
      add(1, 2, 3);
    }
  }

  // The triangles of one class. They share vertices only with each other.
  struct Part {
    std::size_t index = 0;  // index into asset_.parts
    // Indices of the vertices of the two latest rows of samples, by column, and the numbers of these rows. Both arrays
    // have row r in the element r % 2.
    std::array<std::vector<std::uint32_t>, 2> vertices;
    std::array<int, 2> row{-1, -1};
  };

  Part& partOf(float own) {
    const std::int64_t number = std::isfinite(own) ? std::llround(own) : -1;
    const auto [found, isNew] = parts_.try_emplace(number);
    if (!isNew) return found->second;
    found->second.index = asset_.parts.size();
    AssetPart part;
    part.node = "heights";
    part.material = !classes_ ? "heights" : number < 0 ? "no class" : fmt::format("{}", number);
    part.fileMaterial.name = part.material;
    BaseColor color;
    color.stated = false;
    color.image = options_.textures ? image_ : nullptr;
    color.colored = color.textured = color.image != nullptr;
    // The name tells callers that read without textures first that this part has one.
    if (image_ != nullptr) part.texture = wanted_.image.filename().string();
    setColor(part.fileMaterial, std::move(color), file_, options_, images_);
    asset_.parts.push_back(std::move(part));
    return found->second;
  }

  std::uint32_t vertexOf(Part& part, int column, int row, const Vec3d& place) {
    const auto turn = static_cast<std::size_t>(row) % 2;
    if (part.row[turn] != row) part.vertices[turn].assign(static_cast<std::size_t>(heights_.width), kNew);
    part.row[turn] = row;
    std::uint32_t& known = part.vertices[turn][static_cast<std::size_t>(column)];
    if (known != kNew) return known;
    AssetPart& to = asset_.parts[part.index];
    known = static_cast<std::uint32_t>(to.positions.size());
    to.positions.push_back(static_cast<Vec3f>(place));
    if (image_ != nullptr) {
      const auto [x, y] = heights_.place(column, row);
      auto [c, r] = photo_.sample(x, y);
      if (!(c >= 0 && c < photo_.width && r >= 0 && r < photo_.height)) {
        c = std::clamp(c, 0.5, photo_.width - 0.5);
        r = std::clamp(r, 0.5, photo_.height - 0.5);
        ++beside_;
      }
      to.uvs.push_back({static_cast<float>(c / photo_.width), static_cast<float>(1 - r / photo_.height)});
    }
    return known;
  }

  const std::filesystem::path& file_;
  const AssetOptions& options_;
  const HeightOptions& wanted_;
  Raster heights_;
  std::optional<Raster> classes_;
  Raster photo_;                           // georeference of the image, without values
  std::size_t beside_ = 0;                 // number of vertices that the image does not cover
  std::size_t cells_ = 0, unclassed_ = 0;  // numbers of cells, and of those without a class
  std::shared_ptr<const Texture> image_;
  ColorImages images_{file_, true};
  Affine localFromEarth_;
  std::array<std::vector<Vec3d>, 2> places_;
  std::map<std::int64_t, Part> parts_;
  Asset asset_;
};

}  // namespace

Asset readHeightAsset(const std::filesystem::path& file, const AssetOptions& options) {
  return HeightAsset(file, options).build();
}

}  // namespace scanmill
