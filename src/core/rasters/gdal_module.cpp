// libscanmill_rasters.so: GDAL behind the interface of rasters/rasters_interface.h.

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <gdal.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/earth.h"
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
    known_ = !definition.empty() && OSRSetFromUserInput(handle_, definition.c_str()) == OGRERR_NONE;
    OSRSetAxisMappingStrategy(handle_, OAMS_TRADITIONAL_GIS_ORDER);
  }
  explicit Reference(OGRSpatialReferenceH handle) : handle_(handle), known_(true) {
    OSRSetAxisMappingStrategy(handle_, OAMS_TRADITIONAL_GIS_ORDER);
  }
  ~Reference() { OSRDestroySpatialReference(handle_); }
  Reference(const Reference&) = delete;
  Reference& operator=(const Reference&) = delete;

  // Reads a .prj, of Esri's old kind too.
  void readEsri(const std::string& file) {
    char** const lines = CSLLoad(file.c_str());
    known_ = lines != nullptr && OSRImportFromESRI(handle_, lines) == OGRERR_NONE;
    CSLDestroy(lines);
  }

  std::string text() const {
    char* text = nullptr;
    if (known_) OSRExportToWkt(handle_, &text);
    std::string copy = text == nullptr ? "" : text;
    CPLFree(text);
    return copy;
  }

  bool known() const { return known_; }

  void describe(RasterHeader& header) const {
    if (!known_) return;
    header.geographic = OSRIsGeographic(handle_) != 0;
    if (header.geographic) {
      header.perUnit = degrees(OSRGetAngularUnits(handle_, nullptr));
      if (std::fabs(header.perUnit - 1) < 1e-9) header.perUnit = 1;  // definitions round it
      const double earth = OSRGetSemiMajor(handle_, nullptr) / kEarthRadius;
      if (OSRIsDerivedGeographic(handle_) != 0) header.foreign = "degrees of a sphere with another pole";
      if (!(earth > 0.99 && earth < 1.01)) header.foreign = "degrees of another body than the earth";
    } else {
      header.perUnit = OSRGetLinearUnits(handle_, nullptr);
      if (OSRIsGeocentric(handle_) != 0) header.foreign = "earth-centred coordinates";
      OGRAxisOrientation x = OAO_East, y = OAO_North;
      OSRGetAxis(handle_, "PROJCS", 0, &x);
      OSRGetAxis(handle_, "PROJCS", 1, &y);
      const auto are = [&](OGRAxisOrientation first, OGRAxisOrientation second) { return x == first && y == second; };
      if (are(OAO_South, OAO_West) || are(OAO_East, OAO_South) || are(OAO_West, OAO_North)) {
        header.foreign = "coordinates that mirror the ground, with axes south and west or the like";
      }
    }
    if (OSRIsVertical(handle_) == 0) return;
    char* name = nullptr;
    header.metresPerHeight = OSRGetTargetLinearUnits(handle_, "VERT_CS", &name);
    header.heightUnit = name == nullptr ? "unit" : name;
    OGRAxisOrientation points = OAO_Up;
    OSRGetAxis(handle_, "VERT_CS", 0, &points);
    if (points == OAO_Down) header.metresPerHeight *= -1;
  }

  // Fills stretch and utm of a header.
  void measure(RasterHeader& header) const {
    if (!known_ || OSRIsProjected(handle_) == 0) return;
    const double step = 100;  // m
    const auto& t = header.transform;
    const double x = t[0] + header.width / 2.0 * t[1] + header.height / 2.0 * t[2];
    const double y = t[3] + header.width / 2.0 * t[4] + header.height / 2.0 * t[5];
    const double unit = OSRGetLinearUnits(handle_, nullptr);
    std::array<double, 3> east{x, x + step / unit, x};
    std::array<double, 3> north{y, y, y + step / unit};
    OSRStripVertical(handle_);
    const Reference geographic(OSRCloneGeogCS(handle_));
    if (!transform(geographic, east, north)) return;
    const double radian = OSRGetAngularUnits(geographic.handle_, nullptr);
    const double flat = OSRGetInvFlattening(handle_, nullptr);
    const double eccentricity2 = flat > 1 ? (2 - 1 / flat) / flat : 0;
    // Radii of curvature of the ellipsoid: along the meridian, and across it.
    const double w = 1 - eccentricity2 * std::pow(std::sin(north[0] * radian), 2);
    const double across = OSRGetSemiMajor(handle_, nullptr) / std::sqrt(w);
    const double along = across * (1 - eccentricity2) / w;
    for (const std::size_t k : {std::size_t{1}, std::size_t{2}}) {
      const double dx = (east[k] - east[0]) * radian * std::cos(north[0] * radian) * across;
      const double dy = (north[k] - north[0]) * radian * along;
      const double stretch = step / std::hypot(dx, dy);
      if (std::fabs(std::log(stretch)) >= std::fabs(std::log(header.stretch))) header.stretch = stretch;
    }
    const int zone = static_cast<int>(std::floor((degrees(east[0] * radian) + 180) / 6)) % 60 + 1;
    header.utm = (north[0] < 0 ? 32700 : 32600) + zone;
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
    header.placed = GDALGetGeoTransform(set_, header.transform.data()) == CE_None;
    const char* const reference = GDALGetProjectionRef(set_);
    header.reference = reference == nullptr ? "" : reference;
    Reference system(header.reference);
    char** const files = GDALGetFileList(set_);
    for (int i = 0; i < CSLCount(files); ++i) header.files.emplace_back(files[i]);
    CSLDestroy(files);
    for (const char* ending : {".prj", ".PRJ"}) {
      const std::string prj = std::filesystem::path(file_).replace_extension(ending).string();
      std::error_code error;
      if (!header.reference.empty() || !std::filesystem::exists(prj, error)) continue;
      system.readEsri(prj);
      header.reference = system.text();
      if (std::find(header.files.begin(), header.files.end(), prj) == header.files.end()) header.files.push_back(prj);
    }
    system.describe(header);
    if (header.placed) system.measure(header);
    CPLErrorReset();
    return header;
  }

  bool hasGaps() const override {
    for (int i = 1; driver_ == "VRT" && i <= GDALGetRasterCount(set_); ++i) {
      GDALRasterBandH band = GDALGetRasterBand(set_, i);
      const int covered = GDALGetDataCoverageStatus(band, 0, 0, GDALGetRasterXSize(set_), GDALGetRasterYSize(set_),
                                                    GDAL_DATA_COVERAGE_STATUS_EMPTY, nullptr);
      if ((covered & GDAL_DATA_COVERAGE_STATUS_EMPTY) != 0 && GDALGetMaskFlags(band) == GMF_ALL_VALID) return true;
    }
    return false;
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
    const std::size_t count = static_cast<std::size_t>(xywh[2]) * static_cast<std::size_t>(xywh[3]);
    // GDAL before 3.7 has no type for signed bytes.
    const char* const type = GDALGetMetadataItem(handle, "PIXELTYPE", "IMAGE_STRUCTURE");
    if (type != nullptr && EQUAL(type, "SIGNEDBYTE")) {
      for (std::size_t i = 0; i < count; ++i) values[i] -= values[i] > 127 ? 256 : 0;
    }
    int has = 0;
    double none = GDALGetRasterNoDataValue(handle, &has);
    if (has == 0 && driver_ == "AAIGrid") none = -9999;  // the default of Esri's text grids
    const bool marked = std::isfinite(none) && (has != 0 || driver_ == "AAIGrid");
    // Files state this value in float32 or as a text: with six digits, if it is as large as -3.40282e+38.
    const double rounded = std::fabs(none) * (std::fabs(none) > 1e6 ? 1e-5 : 1e-7);
    const double scale = GDALGetRasterScale(handle, nullptr);
    const double offset = GDALGetRasterOffset(handle, nullptr);
    if (GDALGetMaskFlags(handle) != GMF_ALL_VALID) dropWhereZero(GDALGetMaskBand(handle), xywh, values);
    for (int i = 1; i <= GDALGetRasterCount(set_); ++i) {
      GDALRasterBandH alpha = GDALGetRasterBand(set_, i);
      if (GDALGetRasterColorInterpretation(alpha) == GCI_AlphaBand) dropWhereZero(alpha, xywh, values);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const bool missing = marked && std::fabs(values[i] - none) <= rounded;
      values[i] = missing ? kNoValue : values[i] * scale + offset;
    }
  }

 private:
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

class Gdal final : public RastersModule {
 public:
  Gdal() {
    GDALAllRegister();
    CPLSetErrorHandler(CPLQuietErrorHandler);  // this handler prints nothing; fail() gets the messages
    // GDAL guesses the type of a text grid by its first samples, and would drop the fractions of later ones.
    CPLSetConfigOption("AAIGRID_DATATYPE", "Float64");
  }
  std::unique_ptr<RasterReader> open(const std::string& file) const override {
    return std::make_unique<GdalReader>(file);
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
};

}  // namespace

}  // namespace scanmill

SCANMILL_MODULE(RastersModule, Gdal)
