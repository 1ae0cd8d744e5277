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

constexpr std::uint32_t kNoVertex = std::numeric_limits<std::uint32_t>::max();

class HeightAsset {
 public:
  HeightAsset(const std::filesystem::path& file, const AssetOptions& options)
      : file_(file),
        options_(options),
        heights_(readRaster(file, {.every = options.heights.every, .within = options.heights.within})) {}

  Asset build() {
    if (options_.up && *options_.up != 'z') fail("heights are always along z: leave out `up`");
    if (heights_.width < 2 || heights_.height < 2) {
      fail("has fewer than two samples along an axis: a surface needs at least two");
    }
    asset_.up = 'z';
    asset_.upDeclared = true;
    asset_.statedUnit = 1;
    checkHeights();
    checkCoordinates();
    placeOnEarth();
    if (!classFile_.empty()) readClasses();
    if (!imageFile_.empty()) readImage();
    computePositions(0);
    for (int row = 0; row + 1 < heights_.height; ++row) {
      computePositions(row + 1);
      for (int column = 0; column + 1 < heights_.width; ++column) addCell(column, row);
    }
    if (outsideImage_ > 0) {
      warn("{}: does not cover {} of the vertices of {}, which have the colour of its edge", imageFile_.string(),
           grouped(outsideImage_), file_.string());
    }
    if (unclassed_ > 0) {
      warn("{}: has no class for {} of the {} cells of {}, whose material is called 'no class'", classFile_.string(),
           grouped(unclassed_), grouped(cells_), file_.string());
    }
    if (asset_.parts.empty()) fail("has no cell whose four samples all have heights");
    return std::move(asset_);
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const { throw InputError({file_.string()}, problem); }

  std::size_t indexOf(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(heights_.width) + static_cast<std::size_t>(column);
  }

  // Returns the earth-centred position (m) of raster coordinates x, y in degrees or other angles, and a height z (m).
  Vec3d onEarth(double x, double y, double z) const {
    return earthCentred(radians(x * heights_.system.perUnit), radians(y * heights_.system.perUnit), z);
  }

  // Sets the asset's coordinate system, and its origin or, if the raster is in degrees, localFromEarth_.
  void placeOnEarth() {
    const auto [x, y] = heights_.centreOf(heights_.width / 2, heights_.height / 2);
    const double unit = options_.metresPerUnit;
    if (heights_.system.geographic) {
      // If the number of samples is even, the middle lies between two of them.
      const auto [x2, y2] = heights_.centreOf((heights_.width - 1) / 2, (heights_.height - 1) / 2);
      const double middleX = (x + x2) / 2, middleY = (y + y2) / 2;
      localFromEarth_ = eastNorthUp(onEarth(middleX, middleY, 0));
      asset_.ownMiddle = true;
      asset_.system = fmt::format("[{}, {}]", middleX, middleY);
      return;
    }
    if (unit == 1) asset_.system = heights_.system.definition;
    asset_.origin = {std::floor(x * heights_.system.perUnit) * unit, std::floor(y * heights_.system.perUnit) * unit, 0};
  }

  // Throws InputError if heights are higher or deeper than any on the earth.
  void checkHeights() const {
    constexpr double kHighest = 30e3;  // m; above heights and depths on the earth, below usual no-data values but -9999
    const auto [low, high] = heights_.range();
    const double farthest = -low > high ? low : high;
    if (std::isfinite(farthest) && std::fabs(farthest) * options_.metresPerUnit > kHighest) {
      fail(
          fmt::format("has a height of {:.9g} m: if this value marks missing samples, say so by gdal_edit.py "
                      "-a_nodata; if heights are not in metres, by gdal_edit.py -units",
                      farthest));
    }
  }

  // Throws InputError if a latitude is beyond a pole. If undeclared coordinates seem to be degrees, because hills would
  // be needles if they were metres, warns if the raster has a coordinate system, else throws InputError.
  void checkCoordinates() const {
    constexpr double kPole = 90 + 1e-6;  // degrees, with rounding
    constexpr double kSteepest = 3;      // largest ratio of height range to horizontal extent of a raster in metres
    const auto [low, high] = heights_.range();
    const auto [x, y] = heights_.centreOf(0, 0);
    const auto [x2, y2] = heights_.centreOf(heights_.width - 1, heights_.height - 1);
    const double farthestX = std::max(std::fabs(x), std::fabs(x2)), farthestY = std::max(std::fabs(y), std::fabs(y2));
    if (heights_.system.geographic && farthestY * heights_.system.perUnit > kPole) {
      fail(
          fmt::format("is in degrees, as its coordinate system says, but has the latitude {:.9g}: state "
                      "the system of its coordinates by gdal_edit.py -a_srs",
                      farthestY * heights_.system.perUnit));
    }
    if (heights_.system.geographic || options_.metresPerUnit != 1 || farthestX > 360 || farthestY > 90) return;
    const double extent = std::hypot(x2 - x, y2 - y);
    if (!(high - low > kSteepest * extent)) return;
    if (!heights_.system.definition.empty()) {
      warn(
          "{}: rises by {:.4g} m within {:.4g} units of its coordinate system: if its coordinates are "
          "degrees, say so by 'gdal_edit.py -a_srs EPSG:4326'",
          file_.string(), high - low, extent);
      return;
    }
    fail(
        fmt::format("rises by {:.4g} m within {:.4g} metres or degrees, but has no coordinate system: put this into a "
                    ".prj file beside it, or into the file by gdal_edit.py -a_srs (degrees are EPSG:4326)",
                    high - low, extent));
  }

  // Computes the positions of a row of samples for addCell(). Only the two latest rows are stored.
  void computePositions(int row) {
    std::vector<Vec3d>& positions = positions_[static_cast<std::size_t>(row) % 2];
    positions.clear();
    for (int column = 0; column < heights_.width; ++column) positions.push_back(positionOf(column, row));
  }

  // Returns the position of a sample (m), relative to the asset's origin.
  Vec3d positionOf(int column, int row) const {
    const auto [x, y] = heights_.centreOf(column, row);
    const double z = double{heights_.values[indexOf(column, row)]};
    const double unit = options_.metresPerUnit;
    if (heights_.system.geographic) return localFromEarth_ * onEarth(x, y, z) * unit;
    return Vec3d{x * heights_.system.perUnit, y * heights_.system.perUnit, z} * unit - asset_.origin;
  }

  // Reads a band of another raster within boundsOfHeights(). Throws InputError if the coordinate systems differ.
  Raster readBeside(const std::filesystem::path& file, RasterUse use, int band) const {
    Raster raster = readRaster(file, {.use = use, .band = band, .within = boundsOfHeights()});
    if (sameReference(heights_, raster)) return raster;
    throw InputError({file.string()}, "has another coordinate system than {}: convert it by `gdalwarp -t_srs`",
                     file_.string());
  }

  // Reads the class raster into classes_. Throws InputError if a class is not a whole number.
  void readClasses() {
    classes_ = readBeside(classFile_, RasterUse::Classes, 1);
    const auto isFraction = [](float value) { return std::isfinite(value) && value != std::round(value); };
    const auto fraction = std::ranges::find_if(classes_->values, isFraction);
    if (fraction == classes_->values.end()) return;
    throw InputError({classFile_.string()},
                     "has {} samples that are no whole numbers, such as {:.6g}, but classes are: resample it "
                     "by `gdalwarp -r near`, and leave out scale and offset by `gdal_translate -a_scale 1 "
                     "-a_offset 0`",
                     grouped(static_cast<std::size_t>(std::ranges::count_if(classes_->values, isFraction))), *fraction);
  }

  // Returns the x and y bounds of the height samples, extended by one sample on each side.
  RasterBounds boundsOfHeights() const {
    RasterBounds bounds{INFINITY, INFINITY, -INFINITY, -INFINITY};
    for (const int column : {-1, heights_.width}) {
      for (const int row : {-1, heights_.height}) {
        const auto [x, y] = heights_.centreOf(column, row);
        bounds = {std::min(bounds[0], x), std::min(bounds[1], y), std::max(bounds[2], x), std::max(bounds[3], y)};
      }
    }
    return bounds;
  }

  // Guesses from the greatest value of all channels whether white is 1, 255 or 65535, and returns this value.
  double whiteOf(const std::array<std::vector<float>, 3>& channels) const {
    double greatest = 0;
    bool areIntegers = true;
    for (const std::vector<float>& channel : channels) {
      for (const float value : channel) {
        if (!std::isfinite(value)) continue;
        greatest = std::max(greatest, double{value});
        areIntegers = areIntegers && value == std::floor(value);
      }
    }
    if (greatest <= 255) return greatest > 1 || areIntegers ? 255 : 1;
    constexpr double kWhite = 65535;
    if (greatest < kWhite / 4 || greatest > kWhite) {
      warn(
          "{}: its brightest value is {:.6g}, but white is 65535 in an image of more than 8 bits: scale it "
          "by 'gdal_translate -ot Byte -scale'",
          imageFile_.string(), greatest);
    }
    return kWhite;
  }

  // Reads the colour raster into image_ and its grid into imageGrid_.
  void readImage() {
    const std::array<int, 3> bands = colorBands(imageFile_);
    std::array<std::vector<float>, 3> channels;  // green or blue is empty if it is the same as red
    for (std::size_t k = 0; k < 3; ++k) {
      if (k > 0 && bands[k] == bands[0]) continue;
      Raster channel = readBeside(imageFile_, RasterUse::Colors, bands[k]);
      channels[k] = std::move(channel.values);
      imageGrid_ = channel;
    }
    const double white = whiteOf(channels);
    auto image = std::make_shared<Texture>();
    image->file = imageFile_.string();
    image->width = static_cast<std::uint32_t>(imageGrid_.width);
    image->height = static_cast<std::uint32_t>(imageGrid_.height);
    image->rgba.resize(channels[0].size() * 4, 255);
    std::size_t colorless = 0;
    for (std::size_t i = 0; i < channels[0].size(); ++i) {
      // The first row of a texture is the image's bottom.
      const std::size_t row = i / image->width;
      std::uint8_t* const texel = &image->rgba[4 * ((image->height - 1 - row) * image->width + i % image->width)];
      bool isColorless = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto value = double{channels[channels[k].empty() ? 0 : k][i]};
        if (std::isfinite(value)) isColorless = false;
        texel[k] = static_cast<std::uint8_t>(
            std::lround(std::isfinite(value) ? std::clamp(value * 255 / white, 0.0, 255.0) : 0));
      }
      colorless += isColorless ? 1 : 0;
    }
    if (colorless > 0) {
      warn("{}: {} samples have no colour and count as black", image->file, grouped(colorless));
    }
    image_ = std::move(image);
  }

  // Adds the two triangles of the cell between (column, row) and (column + 1, row + 1) to the mesh of the cell's class,
  // unless one of its four samples has no height. positions_ must hold these two rows.
  void addCell(int column, int row) {
    const std::array<std::array<int, 2>, 4> corners{
        {{column, row}, {column, row + 1}, {column + 1, row + 1}, {column + 1, row}}};
    std::array<Vec3d, 4> positions;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto [c, r] = corners[k];
      if (!std::isfinite(heights_.values[indexOf(c, r)])) return;
      positions[k] = positions_[static_cast<std::size_t>(r) % 2][static_cast<std::size_t>(c)];
    }
    const auto [x, y] = heights_.centreOf(column, row);
    const auto [x2, y2] = heights_.centreOf(column + 1, row + 1);
    const float classNumber = classes_ ? classes_->valueAt((x + x2) / 2, (y + y2) / 2) : 0;
    ++cells_;
    unclassed_ += std::isfinite(classNumber) ? 0 : 1;
    ClassMesh& mesh = meshOf(classNumber);
    std::array<std::uint32_t, 4> v{};
    for (std::size_t k = 0; k < 4; ++k) v[k] = vertexOf(mesh, corners[k][0], corners[k][1], positions[k]);
    // Triangles must face up, in whichever directions rows and columns run.
    const bool facesDown = cross(positions[1] - positions[0], positions[2] - positions[0]).z < 0;
    const auto addTriangle = [&](std::size_t a, std::size_t b, std::size_t c) {
      asset_.parts[mesh.part].triangles.push_back(facesDown ? Triangle{v[a], v[c], v[b]} : Triangle{v[a], v[b], v[c]});
    };
    if (length(positions[2] - positions[0]) <= length(positions[3] - positions[1])) {
      addTriangle(0, 1, 2);
      addTriangle(0, 2, 3);
    } else {
      addTriangle(0, 1, 3);
      addTriangle(1, 2, 3);
    }
  }

  // The triangles of one class. Meshes of different classes share no vertices.
  struct ClassMesh {
    std::size_t part = 0;  // index into asset_.parts
    // Indices of the vertices of the two latest rows of samples, by column, and the numbers of these rows. Both arrays
    // have row r in the element r % 2.
    std::array<std::vector<std::uint32_t>, 2> vertices;
    std::array<int, 2> rows{-1, -1};
  };

  // Returns the mesh of a class. `classNumber` is NaN for cells without a class.
  ClassMesh& meshOf(float classNumber) {
    const std::int64_t number = std::isfinite(classNumber) ? std::llround(classNumber) : -1;
    const auto [entry, isNew] = meshes_.try_emplace(number);
    ClassMesh& mesh = entry->second;
    if (!isNew) return mesh;
    mesh.part = asset_.parts.size();
    AssetPart& part = asset_.parts.emplace_back();
    part.node = "heights";
    part.material = !classes_ ? "heights" : number < 0 ? "no class" : fmt::format("{}", number);
    part.fileMaterial.name = part.material;
    const auto image = options_.textures ? image_ : nullptr;
    // Also set if textures are not loaded: the name tells callers that the part has a texture.
    if (image_ != nullptr) part.texture = imageFile_.filename().string();
    using enum BaseColor::Source;
    setColor(part.fileMaterial, {.source = image ? Image : None, .image = image}, file_, options_, images_);
    return mesh;
  }

  // Returns the index of a sample's vertex in the mesh of a class; adds the vertex if the mesh lacks it.
  std::uint32_t vertexOf(ClassMesh& mesh, int column, int row, const Vec3d& position) {
    const auto slot = static_cast<std::size_t>(row) % 2;
    if (mesh.rows[slot] != row) mesh.vertices[slot].assign(static_cast<std::size_t>(heights_.width), kNoVertex);
    mesh.rows[slot] = row;
    std::uint32_t& vertex = mesh.vertices[slot][static_cast<std::size_t>(column)];
    if (vertex != kNoVertex) return vertex;
    AssetPart& part = asset_.parts[mesh.part];
    vertex = static_cast<std::uint32_t>(part.positions.size());
    part.positions.push_back(static_cast<Vec3f>(position));
    if (image_ != nullptr) part.uvs.push_back(uvOf(column, row));
    return vertex;
  }

  // Returns the texture coordinates of a sample, clamped to the image if the image does not cover the sample.
  Vec2f uvOf(int column, int row) {
    const auto [x, y] = heights_.centreOf(column, row);
    auto [imageColumn, imageRow] = imageGrid_.columnAndRow(x, y);
    const double width = imageGrid_.width, height = imageGrid_.height;
    if (!(imageColumn >= 0 && imageColumn < width && imageRow >= 0 && imageRow < height)) {
      imageColumn = std::clamp(imageColumn, 0.5, width - 0.5);
      imageRow = std::clamp(imageRow, 0.5, height - 0.5);
      ++outsideImage_;
    }
    return {static_cast<float>(imageColumn / width), static_cast<float>(1 - imageRow / height)};
  }

  const std::filesystem::path& file_;
  const AssetOptions& options_;
  const std::filesystem::path &classFile_ = options_.heights.classes, &imageFile_ = options_.heights.image;
  Raster heights_;
  std::optional<Raster> classes_;
  RasterGrid imageGrid_;                   // georeference of the image
  std::size_t outsideImage_ = 0;           // number of vertices that the image does not cover
  std::size_t cells_ = 0, unclassed_ = 0;  // numbers of all cells and of cells without a class
  std::shared_ptr<const Texture> image_;
  ColorImages images_{file_, true};
  Affine localFromEarth_;
  std::array<std::vector<Vec3d>, 2> positions_;  // m; element r % 2 has the positions of row r
  std::map<std::int64_t, ClassMesh> meshes_;     // by class; -1: no class
  Asset asset_;
};

}  // namespace

Asset readHeightAsset(const std::filesystem::path& file, const AssetOptions& options) {
  return HeightAsset(file, options).build();
}

}  // namespace scanmill
