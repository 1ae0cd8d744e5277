#pragma once

// The interface of libscanmill_rasters.so, in which GDAL is (base/module.h).

#include <array>
#include <memory>
#include <string>

#include "base/module.h"

namespace scanmill {

struct RasterHeader {
  int width = 0;   // samples
  int height = 0;  // samples, the first row is the northern one as a rule
  int bands = 0;
  bool placed = false;                                // whether it says where it lies
  std::array<double, 6> transform{0, 1, 0, 0, 0, 1};  // x = t0 + c t1 + r t2, y = t3 + c t4 + r t5, c and r from edges
  bool geographic = false;                            // x and y are longitude and latitude, in degrees
  double metresPerUnit = 1;                           // of x and y, where it is not geographic
  std::string reference;                              // the coordinate system's definition (WKT); empty: not said
};

// A raster that is open for reading.
class RasterReader {
 public:
  virtual ~RasterReader() = default;
  virtual RasterHeader header() const = 0;
  // Reads a window of a band (from 1) into columns x rows floats, the means of the samples that fall on one where
  // `mean`, else the nearest. What has no value is NaN; scale, offset and the unit of the band are taken in, so that
  // heights are metres. Throws std::runtime_error in GDAL's words.
  virtual void read(int band, const std::array<int, 4>& xywh, int columns, int rows, bool mean, float* values) = 0;
};

class RastersModule {
 public:
  static constexpr ModuleFile kFile{"libscanmill_rasters.so", "rasters of heights cannot be read",
                                    "install GDAL (on Debian the package libgdal-dev)"};
  virtual ~RastersModule() = default;
  // Throws std::runtime_error in GDAL's words.
  virtual std::unique_ptr<RasterReader> open(const std::string& file) const = 0;
  // Whether two coordinate systems are the same, whatever their names.
  virtual bool same(const std::string& reference, const std::string& other) const = 0;
};

}  // namespace scanmill
