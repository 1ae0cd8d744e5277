#pragma once

// The interface of libscanmill_rasters.so, the module that links GDAL (base/module.h).

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "base/module.h"
#include "rasters/raster.h"

namespace scanmill {

struct RasterBand {
  std::string type;       // GDAL's name of the type of the samples: "Byte", "Float32", "CFloat32"
  std::string means;      // GDAL's name of what the band holds: "Gray", "Palette", "Red", "Alpha", "Undefined"
  std::string unit;       // unit of the values; empty: not stated
  double marker = 0;      // -9999, the usual no-data value, times the band's scale plus its offset
  bool scaled = false;    // true: the band states a scale or an offset
  bool inverted = false;  // true: 0 is white
};

struct RasterHeader : RasterGrid {
  std::vector<RasterBand> bands;
  int others = 0;                  // number of further rasters in the file
  std::vector<std::string> files;  // the raster's own file, and the other files of which it consists
  std::string driver;              // GDAL's name of the format
};

// A raster that is open for reading.
class RasterReader {
 public:
  virtual ~RasterReader() = default;
  virtual const RasterHeader& header() const = 0;
  // Reads all samples in a window of a band into `values`, row by row. Bands are counted from 1. `xywh`: the window's
  // first column and row, width and height. A sample is NaN if the file says in any way that it has no value. Applies
  // the band's scale and offset. Throws std::runtime_error with GDAL's message.
  virtual void read(int bandNumber, const std::array<int, 4>& xywh, double* values) = 0;
};

class RastersModule {
 public:
  static constexpr ModuleFile kFile{"libscanmill_rasters.so", "rasters of heights cannot be read",
                                    "install GDAL (on Debian the package libgdal-dev)"};
  virtual ~RastersModule() = default;
  // Opens a raster. Throws std::runtime_error with GDAL's message.
  virtual std::unique_ptr<RasterReader> open(const std::string& file) const = 0;
  virtual CoordinateSystem system(const std::string& definition, double x, double y) const = 0;
  virtual CoordinateSystem system(const GeoKeys& keys, double x, double y) const = 0;
  // True if two coordinate systems agree except in name and vertical system, or if either system is unknown.
  virtual bool same(const std::string& reference, const std::string& other) const = 0;
  virtual double shift(const std::string& reference, const std::string& other, double x, double y) const = 0;
};

}  // namespace scanmill
