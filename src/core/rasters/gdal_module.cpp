// libscanmill_rasters.so: GDAL behind the interface of rasters/rasters_interface.h.

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal.h>
#include <ogr_srs_api.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "rasters/rasters_interface.h"

namespace scanmill {

namespace {

[[noreturn]] void fail(const char* otherwise) {
  const std::string text = CPLGetLastErrorMsg();
  CPLErrorReset();
  throw std::runtime_error(text.empty() ? otherwise : text);
}

// A coordinate system whose first axis is x (east) and whose second is y (north), as in the raster.
class Reference {
 public:
  explicit Reference(const std::string& definition) : handle_(OSRNewSpatialReference(nullptr)) {
    known_ = !definition.empty() && OSRSetFromUserInput(handle_, definition.c_str()) == OGRERR_NONE;
    OSRSetAxisMappingStrategy(handle_, OAMS_TRADITIONAL_GIS_ORDER);
  }
  ~Reference() { OSRDestroySpatialReference(handle_); }
  Reference(const Reference&) = delete;
  Reference& operator=(const Reference&) = delete;

  bool known() const { return known_; }
  bool geographic() const { return known_ && OSRIsGeographic(handle_) != 0; }
  double metresPerUnit() const {
    return known_ && OSRIsProjected(handle_) != 0 ? OSRGetLinearUnits(handle_, nullptr) : 1;
  }
  bool same(const Reference& other) const { return OSRIsSame(handle_, other.handle_) != 0; }

 private:
  OGRSpatialReferenceH handle_;
  bool known_ = false;
};

class GdalReader final : public RasterReader {
 public:
  explicit GdalReader(const std::string& file) : set_(GDALOpen(file.c_str(), GA_ReadOnly)) {
    if (set_ == nullptr) fail("is no raster that GDAL knows");
  }
  ~GdalReader() override { GDALClose(set_); }
  GdalReader(const GdalReader&) = delete;
  GdalReader& operator=(const GdalReader&) = delete;

  RasterHeader header() const override {
    RasterHeader header;
    header.width = GDALGetRasterXSize(set_);
    header.height = GDALGetRasterYSize(set_);
    header.bands = GDALGetRasterCount(set_);
    header.placed = GDALGetGeoTransform(set_, header.transform.data()) == CE_None;
    const char* const reference = GDALGetProjectionRef(set_);
    header.reference = reference == nullptr ? "" : reference;
    const Reference system(header.reference);
    header.geographic = system.geographic();
    header.metresPerUnit = system.metresPerUnit();
    CPLErrorReset();
    return header;
  }

  void read(int band, const std::array<int, 4>& xywh, int columns, int rows, bool mean, float* values) override {
    GDALRasterBandH handle = GDALGetRasterBand(set_, band);
    if (handle == nullptr) fail("has no such band");
    GDALRasterIOExtraArg extra;
    INIT_RASTERIO_EXTRA_ARG(extra);
    extra.eResampleAlg = mean ? GRIORA_Average : GRIORA_NearestNeighbour;
    if (GDALRasterIOEx(handle, GF_Read, xywh[0], xywh[1], xywh[2], xywh[3], values, columns, rows, GDT_Float32, 0, 0,
                       &extra) != CE_None) {
      fail("cannot be read");
    }
    int has = 0;
    const double none = GDALGetRasterNoDataValue(handle, &has);
    const double scale = GDALGetRasterScale(handle, nullptr);
    const double offset = GDALGetRasterOffset(handle, nullptr);
    const std::string unit = GDALGetRasterUnitType(handle);
    const double metres = unit == "ft" || unit == "feet" || unit == "foot" ? 0.3048
                          : unit == "US survey foot"                       ? 1200.0 / 3937
                                                                           : 1;
    const auto noneHere = static_cast<float>(none);
    const std::size_t count = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    for (std::size_t i = 0; i < count; ++i) {
      const bool missing = has != 0 && (values[i] == noneHere || (std::isnan(none) && std::isnan(values[i])));
      values[i] = missing ? std::numeric_limits<float>::quiet_NaN()
                          : static_cast<float>((double{values[i]} * scale + offset) * metres);
    }
  }

 private:
  GDALDatasetH set_;
};

class Gdal final : public RastersModule {
 public:
  Gdal() {
    GDALAllRegister();
    CPLSetErrorHandler(CPLQuietErrorHandler);  // this handler prints nothing; fail() gets the messages
    // GDAL must not write files of statistics beside the user's files.
    CPLSetConfigOption("GDAL_PAM_ENABLED", "NO");
  }
  std::unique_ptr<RasterReader> open(const std::string& file) const override {
    return std::make_unique<GdalReader>(file);
  }
  bool same(const std::string& reference, const std::string& other) const override {
    const Reference a(reference);
    const Reference b(other);
    return !a.known() || !b.known() || a.same(b);
  }
};

}  // namespace

}  // namespace scanmill

SCANMILL_MODULE(RastersModule, Gdal)
