#pragma once

// The interface of libscanmill_rasters.so, the module that links GDAL (base/module.h).

#include <array>
#include <memory>
#include <string>

#include "base/module.h"

namespace scanmill {

struct RasterHeader {
  int width = 0;   // number of columns
  int height = 0;  // number of rows; the first row is usually the northernmost
  int bands = 0;
  bool placed = false;                                // true if the file states a geotransform
  std::array<double, 6> transform{0, 1, 0, 0, 0, 1};  // x = t0 + c t1 + r t2, y = t3 + c t4 + r t5; (c, r) = (0, 0)
                                                      // is the outer corner of the first sample
  bool geographic = false;                            // true: x and y are longitude and latitude in degrees
  double metresPerUnit = 1;                           // metres per unit of x and y, if not geographic
  std::string reference;                              // the coordinate system's definition (WKT); empty: not stated
};

// A raster that is open for reading.
class RasterReader {
 public:
  virtual ~RasterReader() = default;
  virtual RasterHeader header() const = 0;
  // Reads a window of a band into columns x rows floats. Bands are counted from 1; `xywh` is the window's first column
  // and row, width and height (samples). Each float is the mean of the samples that it covers if `mean` is set, else
  // the nearest sample; it is NaN if these samples have no value. Scale, offset and unit of the band are applied, so
  // that heights are metres. Throws std::runtime_error with GDAL's message.
  virtual void read(int band, const std::array<int, 4>& xywh, int columns, int rows, bool mean, float* values) = 0;
};

class RastersModule {
 public:
  static constexpr ModuleFile kFile{"libscanmill_rasters.so", "rasters of heights cannot be read",
                                    "install GDAL (on Debian the package libgdal-dev)"};
  virtual ~RastersModule() = default;
  // Opens a raster. Throws std::runtime_error with GDAL's message.
  virtual std::unique_ptr<RasterReader> open(const std::string& file) const = 0;
  // True if two coordinate systems are the same, whatever their names, or if one of them is unknown.
  virtual bool same(const std::string& reference, const std::string& other) const = 0;
};

}  // namespace scanmill
