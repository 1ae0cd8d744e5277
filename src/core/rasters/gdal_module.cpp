// libscanmill_rasters.so: GDAL behind the interface of rasters/rasters_interface.h.

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <gdal.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/earth.h"
#include "base/file.h"
#include "rasters/rasters_interface.h"

namespace scanmill {

namespace {

// Throws GDAL's latest error message or, if there is none, `fallback`.
[[noreturn]] void fail(const char* fallback) {
  const std::string message = CPLGetLastErrorMsg();
  CPLErrorReset();
  throw std::runtime_error(message.empty() ? fallback : message);
}

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();
constexpr double kUsualMarker = -9999;  // marks missing samples in many files; the default of Esri's text grids

// Returns the system with x (east) as its first axis and y (north) as its second, as in rasters.
OGRSpatialReference withEastFirst(OGRSpatialReference reference) {
  reference.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return reference;
}

// Returns the coordinate system of a definition; an empty system if the definition is empty or cannot be read.
OGRSpatialReference referenceOf(const std::string& definition) {
  OGRSpatialReference reference;
  // With these limitations, a definition cannot make GDAL read files or use the network.
  const bool isRead =
      !definition.empty() &&
      reference.SetFromUserInput(definition.c_str(), OGRSpatialReference::SET_FROM_USER_INPUT_LIMITATIONS_get()) ==
          OGRERR_NONE;
  return withEastFirst(isRead ? reference : OGRSpatialReference());
}

// Sets `reference` to the system that Esri's file `prj` defines; clears it if the file cannot be read.
void readEsri(const std::string& prj, OGRSpatialReference& reference) {
  char** const lines = CSLLoad(prj.c_str());
  if (lines == nullptr || reference.importFromESRI(lines) != OGRERR_NONE) reference.Clear();
  CSLDestroy(lines);
}

OGRSpatialReference horizontalOf(OGRSpatialReference reference) {
  reference.StripVertical();
  return reference;
}

// Converts points, in place, from coordinates of one system to another. Returns false if GDAL cannot convert them.
bool convertPoints(const OGRSpatialReference& source, const OGRSpatialReference& target, std::span<double> x,
                   std::span<double> y) {
  const std::unique_ptr<OGRCoordinateTransformation> transformation(
      OGRCreateCoordinateTransformation(&source, &target));
  if (transformation == nullptr) return false;
  const bool isConverted = OCTTransform(OGRCoordinateTransformation::ToHandle(transformation.get()),
                                        static_cast<int>(x.size()), x.data(), y.data(), nullptr) != 0;
  const auto isFinite = [](double coordinate) { return std::isfinite(coordinate); };
  return isConverted && std::ranges::all_of(x, isFinite) && std::ranges::all_of(y, isFinite);
}

// Sets the unit of a system in degrees. If rasters in this system cannot be used, sets `foreign` to the reason.
void describeDegrees(const OGRSpatialReference& reference, CoordinateSystem& system) {
  constexpr double kRounding = 1e-9;       // rounding of degrees in definitions
  constexpr double kLargestMisfit = 0.01;  // largest relative deviation of an earth ellipsoid's radius
  system.perUnit = degrees(reference.GetAngularUnits());
  if (std::fabs(system.perUnit - 1) < kRounding) system.perUnit = 1;
  if (reference.IsDerivedGeographic() != 0) system.foreign = "degrees of a sphere with another pole";
  if (!(std::fabs(reference.GetSemiMajor() / kEarthRadius - 1) < kLargestMisfit)) {
    system.foreign = "degrees of another body than the earth";
  }
}

// Sets the unit of a system whose x and y are lengths. If rasters in it cannot be used, sets `foreign` to the reason.
void describeLengths(const OGRSpatialReference& reference, CoordinateSystem& system) {
  const char* unitName = nullptr;
  system.perUnit = reference.GetLinearUnits(&unitName);
  system.unit = unitName == nullptr ? "unit" : unitName;
  if (reference.IsGeocentric() != 0) system.foreign = "earth-centred coordinates";
  OGRAxisOrientation firstAxis = OAO_East, secondAxis = OAO_North;
  reference.GetAxis("PROJCS", 0, &firstAxis);
  reference.GetAxis("PROJCS", 1, &secondAxis);
  const std::pair axes(firstAxis, secondAxis);
  if (axes == std::pair(OAO_South, OAO_West) || axes == std::pair(OAO_East, OAO_South) ||
      axes == std::pair(OAO_West, OAO_North)) {
    system.foreign = "coordinates that mirror the ground, with axes south and west or the like";
  }
}

// Sets stretch and utm of a projected system at the point (x, y): converts two steps, along x and along y, to
// longitudes and latitudes, and compares their lengths with the lengths on the ellipsoid. The step with the greater
// distortion gives the stretch.
void measureStretch(const OGRSpatialReference& reference, double x, double y, CoordinateSystem& system) {
  constexpr double kStep = 100;  // m
  std::array<double, 3> longitude{x, x + kStep / system.perUnit, x};
  std::array<double, 3> latitude{y, y, y + kStep / system.perUnit};
  const std::unique_ptr<OGRSpatialReference> datum(reference.CloneGeogCS());
  if (datum == nullptr) return;
  const OGRSpatialReference geographic = withEastFirst(*datum);
  if (!convertPoints(horizontalOf(reference), geographic, longitude, latitude)) return;
  const double radiansPerUnit = geographic.GetAngularUnits();
  const double inverseFlattening = reference.GetInvFlattening();  // 0 for a sphere
  const double eccentricity2 = inverseFlattening > 1 ? (2 - 1 / inverseFlattening) / inverseFlattening : 0;
  // Radii of curvature of the ellipsoid (m): across the meridian, and along it.
  const double w = 1 - eccentricity2 * std::pow(std::sin(latitude[0] * radiansPerUnit), 2);
  const double radiusAcross = reference.GetSemiMajor() / std::sqrt(w);
  const double radiusAlong = radiusAcross * (1 - eccentricity2) / w;
  for (const std::size_t k : {std::size_t{1}, std::size_t{2}}) {
    const double dx =
        (longitude[k] - longitude[0]) * radiansPerUnit * std::cos(latitude[0] * radiansPerUnit) * radiusAcross;
    const double dy = (latitude[k] - latitude[0]) * radiansPerUnit * radiusAlong;
    const double stretch = kStep / std::hypot(dx, dy);
    if (std::fabs(std::log(stretch)) >= std::fabs(std::log(system.stretch))) system.stretch = stretch;
  }
  // UTM has 60 zones of 6 degrees from longitude -180, with EPSG's codes 326xx in the north and 327xx in the south.
  const int zone = static_cast<int>(std::floor((degrees(longitude[0] * radiansPerUnit) + 180) / 6)) % 60 + 1;
  system.utm = (latitude[0] < 0 ? 32700 : 32600) + zone;
}

// Describes a system, with the stretch and the UTM zone at the point (x, y), which is in the system's coordinates. An
// empty system is described by CoordinateSystem's defaults.
CoordinateSystem described(const OGRSpatialReference& reference, double x, double y) {
  CoordinateSystem system;
  if (reference.IsEmpty()) return system;
  char* text = nullptr;
  if (reference.exportToWkt(&text) == OGRERR_NONE) system.definition = text;
  CPLFree(text);
  system.geographic = reference.IsGeographic() != 0;
  system.local = !system.geographic && reference.IsProjected() == 0 && reference.IsGeocentric() == 0;
  system.geographic ? describeDegrees(reference, system) : describeLengths(reference, system);
  if (reference.IsVertical() != 0) {
    const char* unitName = nullptr;
    OGRAxisOrientation heightAxis = OAO_Up;
    reference.GetAxis("VERT_CS", 0, &heightAxis);
    system.perHeight = reference.GetTargetLinearUnits("VERT_CS", &unitName) * (heightAxis == OAO_Down ? -1 : 1);
    system.heightUnit = unitName == nullptr ? "unit" : unitName;
  }
  if (reference.IsProjected() != 0) measureStretch(reference, x, y, system);
  CPLErrorReset();
  return system;
}

class GdalReader final : public RasterReader {
 public:
  // Delegates to another constructor, so that the destructor closes the dataset if this constructor throws.
  explicit GdalReader(const std::string& file) : GdalReader(GDALOpen(file.c_str(), GA_ReadOnly)) {
    readHeader(file);
    if (header_.driver == "VRT") markGapsOfMosaic();
  }
  ~GdalReader() override { GDALClose(dataset_); }
  GdalReader& operator=(GdalReader&&) = delete;  // neither copied nor moved

  const RasterHeader& header() const override { return header_; }

  void read(int bandNumber, const std::array<int, 4>& xywh, double* values) override {
    GDALRasterBandH band = GDALGetRasterBand(dataset_, bandNumber);
    if (band == nullptr) fail("has no such band");
    readSamples(band, xywh, values);
    const std::span samples(values, static_cast<std::size_t>(xywh[2]) * static_cast<std::size_t>(xywh[3]));
    // GDAL before 3.7 has no type for signed bytes, and returns them as 0 to 255.
    const char* const type = GDALGetMetadataItem(band, "PIXELTYPE", "IMAGE_STRUCTURE");
    if (type != nullptr && EQUAL(type, "SIGNEDBYTE")) {
      for (double& sample : samples) sample -= sample > 127 ? 256 : 0;
    }
    if (GDALGetMaskFlags(band) != GMF_ALL_VALID) dropWhereZero(GDALGetMaskBand(band), xywh, values);
    for (int i = 1; i <= GDALGetRasterCount(dataset_); ++i) {
      if (isAlpha(GDALGetRasterBand(dataset_, i))) dropWhereZero(GDALGetRasterBand(dataset_, i), xywh, values);
    }
    const double marker = markerOf(band);
    // Relative tolerances within which a sample counts as the no-data value. Files state this value in float32 (24
    // bits), or as a text, which has six digits for huge values such as -3.40282e+38.
    constexpr double kFloatRounding = 1e-7, kTextRounding = 1e-5, kLeastAsText = 1e6;
    const double tolerance = std::fabs(marker) * (std::fabs(marker) > kLeastAsText ? kTextRounding : kFloatRounding);
    const double scale = GDALGetRasterScale(band, nullptr);
    const double offset = GDALGetRasterOffset(band, nullptr);
    for (double& sample : samples) {
      const bool isMissing = std::isfinite(marker) && std::fabs(sample - marker) <= tolerance;
      sample = isMissing ? kNoValue : sample * scale + offset;
    }
  }

 private:
  explicit GdalReader(GDALDatasetH dataset) : dataset_(dataset) {
    if (dataset_ == nullptr) fail("is no raster that GDAL knows");
  }

  void readHeader(const std::string& file) {
    header_.width = GDALGetRasterXSize(dataset_);
    header_.height = GDALGetRasterYSize(dataset_);
    const char* const zeroIsWhite = GDALGetMetadataItem(dataset_, "MINISWHITE", "IMAGE_STRUCTURE");
    for (int i = 1; i <= GDALGetRasterCount(dataset_); ++i) {
      GDALRasterBandH band = GDALGetRasterBand(dataset_, i);
      const double scale = GDALGetRasterScale(band, nullptr);
      const double offset = GDALGetRasterOffset(band, nullptr);
      header_.bands.push_back({.type = GDALGetDataTypeName(GDALGetRasterDataType(band)),
                               .means = GDALGetColorInterpretationName(GDALGetRasterColorInterpretation(band)),
                               .unit = GDALGetRasterUnitType(band),
                               .marker = kUsualMarker * scale + offset,
                               .scaled = scale != 1 || offset != 0,
                               .inverted = zeroIsWhite != nullptr && EQUAL(zeroIsWhite, "YES")});
    }
    // The list has two entries, a name and a description, for each raster; it is empty if the file has only one raster.
    const int rasters = CSLCount(GDALGetMetadata(dataset_, "SUBDATASETS")) / 2;
    header_.others = header_.bands.empty() || rasters == 0 ? rasters : rasters - 1;
    header_.georeferenced = GDALGetGeoTransform(dataset_, header_.transform.data()) == CE_None;
    header_.driver = GDALGetDriverShortName(GDALGetDatasetDriver(dataset_));
    char** const files = GDALGetFileList(dataset_);
    for (int i = 0; i < CSLCount(files); ++i) header_.files.emplace_back(files[i]);
    CSLDestroy(files);
    const char* const definition = GDALGetProjectionRef(dataset_);
    OGRSpatialReference reference = referenceOf(definition == nullptr ? "" : definition);
    for (const char* ending : {".prj", ".PRJ"}) {
      const std::string prj = std::filesystem::path(file).replace_extension(ending).string();
      if (!reference.IsEmpty() || !pathExists(prj)) continue;
      readEsri(prj, reference);
      if (std::ranges::find(header_.files, prj) == header_.files.end()) header_.files.push_back(prj);
    }
    const auto [x, y] = header_.pointAt(header_.width / 2.0, header_.height / 2.0);
    header_.system = described(reference, x, y);
    CPLErrorReset();
  }

  // Sets NaN as the no-data value of a mosaic that has none: GDAL would return 0 where no raster covers the mosaic. The
  // name is removed so that GDAL does not write this change to the mosaic's file.
  void markGapsOfMosaic() {
    GDALSetDescription(dataset_, "");
    for (int i = 1; i <= GDALGetRasterCount(dataset_); ++i) {
      GDALRasterBandH band = GDALGetRasterBand(dataset_, i);
      if (GDALGetMaskFlags(band) == GMF_ALL_VALID && !isAlpha(band)) GDALSetRasterNoDataValue(band, kNoValue);
    }
  }

  static bool isAlpha(GDALRasterBandH band) { return GDALGetRasterColorInterpretation(band) == GCI_AlphaBand; }

  // Returns the no-data value of a band. If none is stated, returns kUsualMarker for Esri's text grids, otherwise NaN.
  double markerOf(GDALRasterBandH band) const {
    int isStated = 0;
    const double marker = GDALGetRasterNoDataValue(band, &isStated);
    if (isStated != 0) return marker;
    return header_.driver == "AAIGrid" ? kUsualMarker : kNoValue;
  }

  // Reads the samples of a window without scale and offset; see RasterReader::read().
  static void readSamples(GDALRasterBandH band, const std::array<int, 4>& xywh, double* values) {
    if (GDALRasterIO(band, GF_Read, xywh[0], xywh[1], xywh[2], xywh[3], values, xywh[2], xywh[3], GDT_Float64, 0, 0) !=
        CE_None) {
      fail("cannot be read");
    }
  }

  // Makes samples NaN where the mask is 0.
  void dropWhereZero(GDALRasterBandH mask, const std::array<int, 4>& xywh, double* values) {
    mask_.resize(static_cast<std::size_t>(xywh[2]) * static_cast<std::size_t>(xywh[3]));
    readSamples(mask, xywh, mask_.data());
    for (std::size_t i = 0; i < mask_.size(); ++i) {
      if (mask_[i] == 0) values[i] = kNoValue;
    }
  }

  GDALDatasetH dataset_;
  RasterHeader header_;
  std::vector<double> mask_;  // storage of dropWhereZero()
};

// Returns a GeoTIFF (TIFF 6.0, 1992) of one pixel with these keys, from which GDAL derives the coordinate system.
std::string tiffOf(const GeoKeys& keys) {
  // Byte order and version; the offset of the directory, which is stored below; the pixel, with padding.
  std::string bytes("II*\0\0\0\0\0\0\0", 10);
  constexpr std::size_t kDirectoryOffsetAt = 4;
  constexpr std::uint32_t kPixelAt = 8;
  const auto put = [&](auto number) { bytes.append(reinterpret_cast<const char*>(&number), sizeof(number)); };
  enum Type : std::uint16_t { Ascii = 2, Short = 3, Long = 4, Double = 12 };
  struct Tag {
    std::uint16_t number;
    Type type;
    std::uint32_t count, value;  // value: the offset of the values, or a value that fits in
  };
  // ImageWidth, ImageLength, BitsPerSample, Compression (none), PhotometricInterpretation (0 is black), StripOffsets,
  // SamplesPerPixel, RowsPerStrip, StripByteCounts.
  std::vector<Tag> tags{{256, Long, 1, 1},  {257, Long, 1, 1},  {258, Short, 1, 8},
                        {259, Short, 1, 1}, {262, Short, 1, 1}, {273, Long, 1, kPixelAt},
                        {277, Short, 1, 1}, {278, Long, 1, 1},  {279, Long, 1, 1}};
  const auto add = [&](std::uint16_t number, Type type, std::string_view values, std::size_t bytesPerValue) {
    // Leaves out lists of at most four bytes, which a TIFF would have to store in the tag itself.
    if (values.size() <= 4) return;
    tags.push_back({number, type, static_cast<std::uint32_t>(values.size() / bytesPerValue),
                    static_cast<std::uint32_t>(bytes.size())});
    bytes += values;
    bytes.resize((bytes.size() + 7) / 8 * 8);
  };
  add(34735, Short, keys.directory, 2);  // GeoKeyDirectoryTag
  add(34736, Double, keys.numbers, 8);   // GeoDoubleParamsTag
  add(34737, Ascii, keys.texts, 1);      // GeoAsciiParamsTag
  const auto directory = static_cast<std::uint32_t>(bytes.size());
  std::memcpy(bytes.data() + kDirectoryOffsetAt, &directory, sizeof(directory));
  put(static_cast<std::uint16_t>(tags.size()));
  for (const Tag& tag : tags) put(tag);
  put(std::uint32_t{0});  // there is no further directory
  return bytes;
}

// Sets the unit of heights from the key VerticalUnits. GDAL ignores this key if the vertical system has another unit:
// LAS files state EPSG:5703, a system in metres, for heights in feet. Depths remain depths.
void setHeightUnit(const GeoKeys& keys, CoordinateSystem& system) {
  constexpr std::uint16_t kVerticalUnits = 4099;
  // Metres per unit by EPSG's code, for metres, feet and US survey feet.
  static const std::map<std::uint16_t, double> kMetres{{9001, 1}, {9002, 0.3048}, {9003, 1200.0 / 3937}};
  struct Entry {
    std::uint16_t key, valueTag, count, value;  // valueTag 0: `value` is the value itself
  } entry{};
  for (std::size_t at = 0; at + sizeof(entry) <= keys.directory.size(); at += sizeof(entry)) {
    std::memcpy(&entry, keys.directory.data() + at, sizeof(entry));
    if (entry.key != kVerticalUnits || entry.valueTag != 0 || !kMetres.contains(entry.value)) continue;
    system.perHeight = std::copysign(kMetres.at(entry.value), system.perHeight.value_or(1));
  }
}

class Gdal final : public RastersModule {
 public:
  Gdal() {
    GDALAllRegister();
    CPLSetErrorHandler(CPLQuietErrorHandler);  // this handler prints nothing; fail() gets the messages
    // GDAL guesses the type of a text grid by its first samples, and would drop the fractions of later ones.
    CPLSetConfigOption("AAIGRID_DATATYPE", "Float64");
    CPLSetConfigOption("GTIFF_REPORT_COMPD_CS", "YES");  // the vertical system too
  }
  std::unique_ptr<RasterReader> open(const std::string& file) const override {
    return std::make_unique<GdalReader>(file);
  }
  CoordinateSystem system(const std::string& definition, double x, double y) const override {
    return described(referenceOf(definition), x, y);
  }
  CoordinateSystem system(const GeoKeys& keys, double x, double y) const override {
    const std::string tiff = tiffOf(keys);
    const std::string name = "/vsimem/" + std::to_string(++keysRead_) + ".tif";
    auto* const bytes = const_cast<GByte*>(reinterpret_cast<const GByte*>(tiff.data()));
    VSIFCloseL(VSIFileFromMemBuffer(name.c_str(), bytes, tiff.size(), 0));
    CoordinateSystem system;
    if (GDALDatasetH const dataset = GDALOpen(name.c_str(), GA_ReadOnly); dataset != nullptr) {
      if (OGRSpatialReferenceH const reference = GDALGetSpatialRef(dataset); reference != nullptr) {
        system = described(withEastFirst(*OGRSpatialReference::FromHandle(reference)), x, y);
      }
      GDALClose(dataset);
    }
    VSIUnlink(name.c_str());
    CPLErrorReset();
    setHeightUnit(keys, system);
    return system;
  }
  bool same(const std::string& reference, const std::string& other) const override {
    const OGRSpatialReference a = referenceOf(reference), b = referenceOf(other), horizontal = horizontalOf(b);
    return a.IsEmpty() || b.IsEmpty() || horizontalOf(a).IsSame(&horizontal) != 0;
  }
  double shift(const std::string& reference, const std::string& other, double x, double y) const override {
    const OGRSpatialReference a = horizontalOf(referenceOf(reference)), b = horizontalOf(referenceOf(other));
    if (a.IsProjected() == 0 || b.IsProjected() == 0) return 0;
    const double unit = a.GetLinearUnits(), otherUnit = b.GetLinearUnits();
    double east = x / unit, north = y / unit;
    const bool isConverted = convertPoints(a, b, {&east, 1}, {&north, 1});
    CPLErrorReset();
    return isConverted ? std::hypot(east * otherUnit - x, north * otherUnit - y) : 0;
  }

 private:
  mutable std::atomic<int> keysRead_ = 0;
};

}  // namespace

}  // namespace scanmill

SCANMILL_MODULE(RastersModule, Gdal)
