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
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "base/earth.h"
#include "base/file.h"
#include "rasters/rasters_interface.h"

namespace scanmill {

namespace {

[[noreturn]] void fail(const char* otherwise) {
  const std::string text = CPLGetLastErrorMsg();
  CPLErrorReset();
  throw std::runtime_error(text.empty() ? otherwise : text);
}

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

// A coordinate system whose first axis is x (east) and whose second is y (north), as in the raster.
class Reference {
 public:
  explicit Reference(const std::string& definition) : handle_(OSRNewSpatialReference(nullptr)) {
    // Neither opens files nor the network, unlike OSRSetFromUserInput().
    known_ = !definition.empty() &&
             OGRSpatialReference::FromHandle(handle_)->SetFromUserInput(
                 definition.c_str(), OGRSpatialReference::SET_FROM_USER_INPUT_LIMITATIONS_get()) == OGRERR_NONE;
    OSRSetAxisMappingStrategy(handle_, OAMS_TRADITIONAL_GIS_ORDER);
  }
  explicit Reference(OGRSpatialReferenceH handle) : handle_(handle), known_(true) {
    OSRSetAxisMappingStrategy(handle_, OAMS_TRADITIONAL_GIS_ORDER);
  }
  ~Reference() { OSRDestroySpatialReference(handle_); }
  Reference(const Reference&) = delete;
  Reference& operator=(const Reference&) = delete;

  void readEsri(const std::string& prj) {
    char** const lines = CSLLoad(prj.c_str());
    known_ = lines != nullptr && OSRImportFromESRI(handle_, lines) == OGRERR_NONE;
    CSLDestroy(lines);
  }

  bool known() const { return known_; }

  // Describes the system with its stretch at a place.
  CoordinateSystem at(double x, double y) const {
    CoordinateSystem system;
    if (!known_) return system;
    char* text = nullptr;
    if (OSRExportToWkt(handle_, &text) == OGRERR_NONE) system.definition = text;
    CPLFree(text);
    system.geographic = OSRIsGeographic(handle_) != 0;
    system.local = !system.geographic && OSRIsProjected(handle_) == 0 && OSRIsGeocentric(handle_) == 0;
    if (system.geographic) {
      system.perUnit = degrees(OSRGetAngularUnits(handle_, nullptr));
      if (std::fabs(system.perUnit - 1) < 1e-9) system.perUnit = 1;  // definitions round it
      const double earth = OSRGetSemiMajor(handle_, nullptr) / kEarthRadius;
      if (OSRIsDerivedGeographic(handle_) != 0) system.foreign = "degrees of a sphere with another pole";
      if (!(earth > 0.99 && earth < 1.01)) system.foreign = "degrees of another body than the earth";
    } else {
      char* name = nullptr;
      system.perUnit = OSRGetLinearUnits(handle_, &name);
      system.unit = name == nullptr ? "unit" : name;
      if (OSRIsGeocentric(handle_) != 0) system.foreign = "earth-centred coordinates";
      OGRAxisOrientation along = OAO_East, across = OAO_North;
      OSRGetAxis(handle_, "PROJCS", 0, &along);
      OSRGetAxis(handle_, "PROJCS", 1, &across);
      const auto are = [&](OGRAxisOrientation a, OGRAxisOrientation b) { return along == a && across == b; };
      if (are(OAO_South, OAO_West) || are(OAO_East, OAO_South) || are(OAO_West, OAO_North)) {
        system.foreign = "coordinates that mirror the ground, with axes south and west or the like";
      }
    }
    if (OSRIsVertical(handle_) != 0) {
      char* name = nullptr;
      OGRAxisOrientation points = OAO_Up;
      OSRGetAxis(handle_, "VERT_CS", 0, &points);
      system.perHeight = OSRGetTargetLinearUnits(handle_, "VERT_CS", &name) * (points == OAO_Down ? -1 : 1);
      system.heightUnit = name == nullptr ? "unit" : name;
    }
    measure(system, x, y);
    CPLErrorReset();
    return system;
  }

  // Changes coordinates to another system. Returns false if they cannot be.
  template <std::size_t Count>
  bool transform(const Reference& other, std::array<double, Count>& x, std::array<double, Count>& y) const {
    OGRCoordinateTransformationH change = OCTNewCoordinateTransformation(handle_, other.handle_);
    if (change == nullptr) return false;
    const bool done = OCTTransform(change, Count, x.data(), y.data(), nullptr) != 0;
    OCTDestroyCoordinateTransformation(change);
    return done && std::all_of(x.begin(), x.end(), [](double d) { return std::isfinite(d); }) &&
           std::all_of(y.begin(), y.end(), [](double d) { return std::isfinite(d); });
  }

  double shift(const Reference& other, double x, double y) const {
    if (!known_ || !other.known_ || OSRIsProjected(handle_) == 0 || OSRIsProjected(other.handle_) == 0) return 0;
    OSRStripVertical(handle_);
    OSRStripVertical(other.handle_);
    const double unit = OSRGetLinearUnits(handle_, nullptr), otherUnit = OSRGetLinearUnits(other.handle_, nullptr);
    std::array<double, 1> east{x / unit}, north{y / unit};
    return transform(other, east, north) ? std::hypot(east[0] * otherUnit - x, north[0] * otherUnit - y) : 0;
  }

  bool same(const Reference& other) const {
    OSRStripVertical(handle_);
    OSRStripVertical(other.handle_);
    return OSRIsSame(handle_, other.handle_) != 0;
  }

 private:
  // Fills stretch and utm.
  void measure(CoordinateSystem& system, double x, double y) const {
    if (OSRIsProjected(handle_) == 0) return;
    const double step = 100;  // m
    std::array<double, 3> east{x, x + step / system.perUnit, x};
    std::array<double, 3> north{y, y, y + step / system.perUnit};
    const Reference flat(OSRClone(handle_));
    OSRStripVertical(flat.handle_);
    const Reference geographic(OSRCloneGeogCS(handle_));
    if (!flat.transform(geographic, east, north)) return;
    const double radian = OSRGetAngularUnits(geographic.handle_, nullptr);
    const double inverse = OSRGetInvFlattening(handle_, nullptr);
    const double eccentricity2 = inverse > 1 ? (2 - 1 / inverse) / inverse : 0;
    // Radii of curvature of the ellipsoid: along the meridian, and across it.
    const double w = 1 - eccentricity2 * std::pow(std::sin(north[0] * radian), 2);
    const double across = OSRGetSemiMajor(handle_, nullptr) / std::sqrt(w);
    const double along = across * (1 - eccentricity2) / w;
    for (const std::size_t k : {std::size_t{1}, std::size_t{2}}) {
      const double dx = (east[k] - east[0]) * radian * std::cos(north[0] * radian) * across;
      const double dy = (north[k] - north[0]) * radian * along;
      const double stretch = step / std::hypot(dx, dy);
      if (std::fabs(std::log(stretch)) >= std::fabs(std::log(system.stretch))) system.stretch = stretch;
    }
    const int zone = static_cast<int>(std::floor((degrees(east[0] * radian) + 180) / 6)) % 60 + 1;
    system.utm = (north[0] < 0 ? 32700 : 32600) + zone;
  }

  OGRSpatialReferenceH handle_;
  bool known_ = false;
};

class GdalReader final : public RasterReader {
 public:
  explicit GdalReader(const std::string& file) : file_(file), set_(GDALOpen(file.c_str(), GA_ReadOnly)) {
    if (set_ == nullptr) fail("is no raster that GDAL knows");
    driver_ = GDALGetDriverShortName(GDALGetDatasetDriver(set_));
  }
  ~GdalReader() override { GDALClose(set_); }
  GdalReader(const GdalReader&) = delete;
  GdalReader& operator=(const GdalReader&) = delete;

  RasterHeader header() const override {
    RasterHeader header;
    header.width = GDALGetRasterXSize(set_);
    header.height = GDALGetRasterYSize(set_);
    for (int i = 1; i <= GDALGetRasterCount(set_); ++i) {
      GDALRasterBandH band = GDALGetRasterBand(set_, i);
      const double scale = GDALGetRasterScale(band, nullptr);
      const double offset = GDALGetRasterOffset(band, nullptr);
      const char* const zero = GDALGetMetadataItem(set_, "MINISWHITE", "IMAGE_STRUCTURE");
      header.bands.push_back({GDALGetDataTypeName(GDALGetRasterDataType(band)),
                              GDALGetColorInterpretationName(GDALGetRasterColorInterpretation(band)),
                              GDALGetRasterUnitType(band), -9999 * scale + offset, scale != 1 || offset != 0,
                              zero != nullptr && EQUAL(zero, "YES")});
    }
    // Each raster of a file has a name and a description here; a file with one raster has none.
    const int named = CSLCount(GDALGetMetadata(set_, "SUBDATASETS")) / 2;
    header.others = header.bands.empty() || named == 0 ? named : named - 1;
    header.georeferenced = GDALGetGeoTransform(set_, header.transform.data()) == CE_None;
    header.driver = driver_;
    const char* const reference = GDALGetProjectionRef(set_);
    Reference system(reference == nullptr ? "" : reference);
    char** const files = GDALGetFileList(set_);
    for (int i = 0; i < CSLCount(files); ++i) header.files.emplace_back(files[i]);
    CSLDestroy(files);
    for (const char* ending : {".prj", ".PRJ"}) {
      const std::string prj = std::filesystem::path(file_).replace_extension(ending).string();
      if (system.known() || !pathExists(prj)) continue;
      system.readEsri(prj);
      if (std::find(header.files.begin(), header.files.end(), prj) == header.files.end()) header.files.push_back(prj);
    }
    const auto& t = header.transform;
    const double column = header.width / 2.0, row = header.height / 2.0;
    header.system = system.at(t[0] + column * t[1] + row * t[2], t[3] + column * t[4] + row * t[5]);
    CPLErrorReset();
    return header;
  }

  void read(int band, const std::array<int, 4>& xywh, double* values) override {
    GDALRasterBandH handle = GDALGetRasterBand(set_, band);
    if (handle == nullptr) fail("has no such band");
    if (driver_ == "VRT" && GDALGetMaskFlags(handle) == GMF_ALL_VALID) {
      // Where no raster of a mosaic lies, GDAL returns the mosaic's value of missing samples, or else 0. Without its
      // name the changed mosaic is not written to its file.
      GDALSetDescription(set_, "");
      GDALSetRasterNoDataValue(handle, kNoValue);
    }
    readSamples(handle, xywh, values);
    const std::span samples(values, static_cast<std::size_t>(xywh[2]) * static_cast<std::size_t>(xywh[3]));
    // GDAL before 3.7 has no type for signed bytes.
    const char* const type = GDALGetMetadataItem(handle, "PIXELTYPE", "IMAGE_STRUCTURE");
    if (type != nullptr && EQUAL(type, "SIGNEDBYTE")) {
      for (double& sample : samples) sample -= sample > 127 ? 256 : 0;
    }
    if (GDALGetMaskFlags(handle) != GMF_ALL_VALID) dropWhereZero(GDALGetMaskBand(handle), xywh, values);
    for (int i = 1; i <= GDALGetRasterCount(set_); ++i) {
      GDALRasterBandH alpha = GDALGetRasterBand(set_, i);
      if (GDALGetRasterColorInterpretation(alpha) == GCI_AlphaBand) dropWhereZero(alpha, xywh, values);
    }
    const double marker = markerOf(handle);
    // Files state the marker in float32 or as a text: with six digits, if it is as large as -3.40282e+38.
    const double rounding = std::fabs(marker) * (std::fabs(marker) > 1e6 ? 1e-5 : 1e-7);
    const double scale = GDALGetRasterScale(handle, nullptr);
    const double offset = GDALGetRasterOffset(handle, nullptr);
    for (double& sample : samples) {
      const bool missing = std::isfinite(marker) && std::fabs(sample - marker) <= rounding;
      sample = missing ? kNoValue : sample * scale + offset;
    }
  }

 private:
  // Returns the value that marks missing samples of a band; NaN if there is none.
  double markerOf(GDALRasterBandH band) const {
    int has = 0;
    const double marker = GDALGetRasterNoDataValue(band, &has);
    if (has != 0) return marker;
    return driver_ == "AAIGrid" ? -9999 : kNoValue;  // the default of Esri's text grids
  }

  static void readSamples(GDALRasterBandH band, const std::array<int, 4>& xywh, double* values) {
    if (GDALRasterIO(band, GF_Read, xywh[0], xywh[1], xywh[2], xywh[3], values, xywh[2], xywh[3], GDT_Float64, 0, 0) !=
        CE_None) {
      fail("cannot be read");
    }
  }

  void dropWhereZero(GDALRasterBandH mask, const std::array<int, 4>& xywh, double* values) {
    mask_.resize(static_cast<std::size_t>(xywh[2]) * static_cast<std::size_t>(xywh[3]));
    readSamples(mask, xywh, mask_.data());
    for (std::size_t i = 0; i < mask_.size(); ++i) {
      if (mask_[i] == 0) values[i] = kNoValue;
    }
  }

  std::string file_;  // the data set's name can change
  GDALDatasetH set_;
  std::string driver_;
  std::vector<double> mask_;
};

// Returns the bytes of a GeoTIFF (TIFF 6.0, 1992) of one pixel with these keys: GDAL derives the coordinate system.
std::string tiffOf(const GeoKeys& keys) {
  std::string bytes("II*\0\0\0\0\0\0\0", 10);  // the first directory's place follows below; the pixel
  const auto put = [&](auto number) { bytes.append(reinterpret_cast<const char*>(&number), sizeof(number)); };
  struct Tag {
    std::uint16_t tag, type;
    std::uint32_t count, value;
  };
  std::vector<Tag> tags{{256, 4, 1, 1}, {257, 4, 1, 1}, {258, 3, 1, 8}, {259, 3, 1, 1}, {262, 3, 1, 1},
                        {273, 4, 1, 8}, {277, 3, 1, 1}, {278, 4, 1, 1}, {279, 4, 1, 1}};
  const auto add = [&](std::uint16_t tag, std::uint16_t type, std::string_view values, std::size_t each) {
    // Values of four bytes or fewer would stand in the tag.
    if (values.size() <= 4) return;
    tags.push_back(
        {tag, type, static_cast<std::uint32_t>(values.size() / each), static_cast<std::uint32_t>(bytes.size())});
    bytes += values;
    bytes.resize((bytes.size() + 7) / 8 * 8);
  };
  add(34735, 3, keys.directory, 2);
  add(34736, 12, keys.numbers, 8);
  add(34737, 2, keys.texts, 1);
  const auto directory = static_cast<std::uint32_t>(bytes.size());
  std::memcpy(bytes.data() + 4, &directory, sizeof(directory));
  put(static_cast<std::uint16_t>(tags.size()));
  for (const Tag& tag : tags) put(tag.tag), put(tag.type), put(tag.count), put(tag.value);
  put(std::uint32_t{0});
  return bytes;
}

// Takes the key of the unit of heights, which GDAL ignores if the vertical system has another one. LAS files state
// EPSG:5703, a system in metres, for heights in feet.
void takeHeightUnit(const GeoKeys& keys, CoordinateSystem& system) {
  constexpr std::uint16_t kVerticalUnit = 4099;
  struct Unit {
    std::uint16_t code;
    double metres;
  };
  constexpr Unit kUnits[] = {{9001, 1}, {9002, 0.3048}, {9003, 1200.0 / 3937}};
  std::uint16_t key[4];
  for (std::size_t at = 0; at + sizeof(key) <= keys.directory.size(); at += sizeof(key)) {
    std::memcpy(key, keys.directory.data() + at, sizeof(key));
    for (const Unit& unit : kUnits) {
      const bool states = key[0] == kVerticalUnit && key[1] == 0 && key[3] == unit.code;
      if (states) system.perHeight = std::copysign(unit.metres, system.perHeight.value_or(1));
    }
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
    return Reference(definition).at(x, y);
  }
  CoordinateSystem system(const GeoKeys& keys, double x, double y) const override {
    const std::string tiff = tiffOf(keys);
    const std::string name = "/vsimem/" + std::to_string(++keysRead_) + ".tif";
    auto* const bytes = const_cast<GByte*>(reinterpret_cast<const GByte*>(tiff.data()));
    VSIFCloseL(VSIFileFromMemBuffer(name.c_str(), bytes, tiff.size(), 0));
    CoordinateSystem system;
    if (GDALDatasetH const set = GDALOpen(name.c_str(), GA_ReadOnly); set != nullptr) {
      if (OGRSpatialReferenceH const stated = GDALGetSpatialRef(set); stated != nullptr) {
        system = Reference(OSRClone(stated)).at(x, y);
      }
      GDALClose(set);
    }
    VSIUnlink(name.c_str());
    CPLErrorReset();
    takeHeightUnit(keys, system);
    return system;
  }
  bool same(const std::string& reference, const std::string& other) const override {
    const Reference a(reference);
    const Reference b(other);
    return !a.known() || !b.known() || a.same(b);
  }
  double shift(const std::string& reference, const std::string& other, double x, double y) const override {
    const double distance = Reference(reference).shift(Reference(other), x, y);
    CPLErrorReset();
    return distance;
  }

 private:
  mutable std::atomic<int> keysRead_ = 0;
};

}  // namespace

}  // namespace scanmill

SCANMILL_MODULE(RastersModule, Gdal)
