#pragma once

// Georeferenced rasters (GeoTIFF and all other formats that GDAL reads) and coordinate systems. The module that links
// GDAL is loaded at the first call, from any thread. If it cannot be loaded, calls throw an Error that says what to
// install.

#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/format_support.h"

namespace scanmill {

struct CoordinateSystem {
  std::string definition;           // the system as well-known text; empty: it is not stated, or cannot be read
  bool local = false;               // true: the system's place on the earth is not known
  bool geographic = false;          // true: x and y are longitude and latitude
  double perUnit = 1;               // metres per unit of x and y; if geographic, degrees per unit
  std::string unit = {};            // name of the unit of x and y, unless geographic
  std::optional<double> perHeight;  // metres per unit of heights, negative if these are depths; none: not stated
  std::string heightUnit = {};      // name of the unit of heights
  std::string foreign = {};         // says what the coordinates are if they cannot be used, in the plural; else empty
  double stretch = 1;               // ratio of lengths in a projected system to those on the ground
  int utm = 0;                      // EPSG's code of the UTM zone in which `stretch` was measured; 0: not known

  // True if lengths differ from those on the ground by more than 1 %, which UTM and national systems avoid.
  bool isStretched() const { return std::fabs(stretch - 1) > 0.01; }
};

// Reads a definition, such as OGC's or Esri's well-known text. Measures the stretch at (x, y), in the system's units.
CoordinateSystem coordinateSystem(std::string_view definition, double x, double y);

// The keys of a GeoTIFF ("OGC GeoTIFF Standard", OGC 19-008r4, 7), which LAS files have too: a directory of uint16, and
// the float64 numbers and texts to which the directory refers.
struct GeoKeys {
  std::string_view directory, numbers, texts;
};
CoordinateSystem coordinateSystem(const GeoKeys& keys, double x, double y);

// The raster files that are read, and the contents that are ignored.
extern const FormatSupport kRasterFormat;

// A rectangle in a raster's coordinates: least x and y, greatest x and y.
using RasterBounds = std::array<double, 4>;

// The positions of the samples of a raster.
struct RasterGrid {
  int width = 0, height = 0;   // numbers of columns and rows; the first row is usually the northernmost
  bool georeferenced = false;  // false: the file has no geotransform, x and y count columns and rows
  // GDAL's geotransform: x = t0 + c t1 + r t2, y = t3 + c t4 + r t5; (c, r) = (0, 0) is the outer corner of the first
  // sample.
  std::array<double, 6> transform{0, 1, 0, 0, 0, 1};
  CoordinateSystem system;  // its stretch is measured at the middle of the complete raster

  // Returns x and y of a position in columns and rows, with fractions; (0, 0) is the raster's outer corner.
  std::array<double, 2> pointAt(double column, double row) const {
    return {transform[0] + column * transform[1] + row * transform[2],
            transform[3] + column * transform[4] + row * transform[5]};
  }
  // Returns x and y of the centre of a sample.
  std::array<double, 2> centreOf(int column, int row) const { return pointAt(column + 0.5, row + 0.5); }
  // Returns the column and row of the point (x, y), the inverse of pointAt().
  std::array<double, 2> columnAndRow(double x, double y) const;
};

struct Raster : RasterGrid {
  std::vector<float> values;  // row by row; NaN for a sample without a value

  // Returns the value of the sample that contains the point (x, y); NaN outside of the raster.
  float valueAt(double x, double y) const;
  // Returns the least and the greatest value; infinity and -infinity if no sample has a value.
  std::array<double, 2> range() const;
};

enum class RasterUse { Heights, Classes, Colors };

struct RasterRequest {
  RasterUse use = RasterUse::Heights;
  int band = 1;
  int every = 1;  // a square of `every` x `every` samples becomes one sample: the mean of those that have a value
  std::optional<RasterBounds> within = std::nullopt;  // bounds of the samples to read; none: all are read
  bool georeferenced = true;  // false: also reads images without a geotransform (the red band of RGB images)
};

// Reads a band of a raster. Heights are converted to metres, positive upwards. A sample has no value if the file marks
// it by a value (NaN too), a mask or an alpha band, or if no raster of a mosaic covers it. Warns of what is left out.
// Throws an InputError that names the file and says what is wrong: it is absent, damaged or no raster, has no
// geotransform though RasterRequest::georeferenced asks for it, lacks the requested band, has too many samples, has no
// samples within the bounds, or holds colours instead of heights, or heights in an unknown unit.
Raster readRaster(const std::filesystem::path& file, const RasterRequest& request);

// True if the rasters have the same horizontal coordinate system, or if the system of either raster is unknown.
bool sameReference(const Raster& a, const Raster& b);

// Returns the distance (m) between two points whose coordinates x and y (m) are the same numbers in two projected
// systems (CoordinateSystem::definition); 0 if the distance is not known, or if GDAL cannot be loaded.
double shiftBetween(const std::string& reference, const std::string& other, double x, double y);

// Returns the numbers of the bands for red, green and blue. If the file does not name these bands, they are 1, 2, 3 or,
// with fewer than three colour bands, 1, 1, 1. Throws InputError, also for colour tables, CMYK, HLS and YCbCr.
std::array<int, 3> colorBands(const std::filesystem::path& file);

}  // namespace scanmill
