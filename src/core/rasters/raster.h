#pragma once

// Georeferenced rasters (GeoTIFF and all other formats that GDAL reads). The module of GDAL is loaded at the first
// call, from any thread. If it cannot be loaded, calls throw an Error that says what to install.

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
  std::vector<float> values;        // row by row; NaN where there is no value
  std::array<double, 6> transform;  // from column and row, counted from the raster's outer edges, to x and y
  bool geographic = false;          // x and y are longitude and latitude in degrees
  double metresPerUnit = 1;         // metres per unit of x and y, if the raster is not geographic
  std::string reference;            // definition of the coordinate system

  // Returns x and y of a sample's centre.
  std::array<double, 2> place(int column, int row) const;
  // Returns column and row of a place, counted from the raster's outer edges; fractions are parts of samples.
  std::array<double, 2> sample(double x, double y) const;
  // Returns the value at a place; NaN outside of the raster.
  float at(double x, double y) const;
};

struct RasterRequest {
  int band = 1;
  int every = 1;     // this many samples along each axis become one
  bool mean = true;  // their mean; else the middle sample, as for class numbers
  std::optional<RasterBounds> within;
  std::size_t mostSamples = 64'000'000;
};

// Reads a raster. Throws an InputError that names the file and says what is wrong: it is absent, damaged or no raster,
// does not say where it lies, has no such band, has more than `mostSamples` samples, or has none within the bounds.
Raster readRaster(const std::filesystem::path& file, const RasterRequest& request);

// True if both have the same coordinate system, or if one does not state its own.
bool sameReference(const Raster& a, const Raster& b);

// Returns how many bands a raster has. Throws as readRaster() does.
int bandsOf(const std::filesystem::path& file);

}  // namespace scanmill
