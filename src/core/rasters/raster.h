#pragma once

// Georeferenced rasters (GeoTIFF and all other formats that GDAL reads). The module that links GDAL is loaded at the
// first call, from any thread. If it cannot be loaded, calls throw an Error that says what to install.

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace scanmill {

// A rectangle in a raster's coordinates: least x and y, greatest x and y.
using RasterBounds = std::array<double, 4>;

struct Raster {
  int width = 0, height = 0;
  std::vector<float> values;        // row by row; NaN for a sample without a value
  std::array<double, 6> transform;  // GDAL's geotransform; column and row are 0 at the raster's outer edges
  bool geographic = false;          // true: x and y are longitude and latitude in degrees
  double metresPerUnit = 1;         // metres per unit of x and y, if not geographic
  std::string reference;            // definition of the coordinate system (WKT); empty: unknown

  // Returns x and y of the centre of a sample.
  std::array<double, 2> place(int column, int row) const;
  // Returns the column and row of the point (x, y), with fractions; 0 is the raster's outer edge.
  std::array<double, 2> sample(double x, double y) const;
  // Returns the value of the sample that contains the point (x, y); NaN outside of the raster.
  float at(double x, double y) const;
};

struct RasterRequest {
  int band = 1;
  int every = 1;     // a square of `every` x `every` samples becomes one sample
  bool mean = true;  // true: the mean of the square; false: its middle sample, for class numbers
  std::optional<RasterBounds> within;
  std::size_t mostSamples = 64'000'000;
};

// Reads a raster. Throws an InputError that names the file and says what is wrong: it is absent, damaged or no raster,
// has no geotransform, lacks the requested band, has more than `mostSamples` samples, or has no samples within the
// bounds.
Raster readRaster(const std::filesystem::path& file, const RasterRequest& request);

// True if the rasters have the same coordinate system, or if the system of one is unknown.
bool sameReference(const Raster& a, const Raster& b);

// Returns how many bands a raster has. Throws as readRaster() does.
int bandsOf(const std::filesystem::path& file);

}  // namespace scanmill
