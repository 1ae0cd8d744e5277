#pragma once

// Rasters that say where on the earth they lie (GeoTIFF and what else GDAL reads). GDAL's module is loaded at the first
// call, from any thread. Where it cannot be loaded, calls throw an Error that says what to install.

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
  std::vector<float> values;        // by rows; NaN where there is none
  std::array<double, 6> transform;  // from column and row, counted from the edges of samples, to x and y
  bool geographic = false;          // x and y are longitude and latitude in degrees
  double metresPerUnit = 1;         // of x and y, where it is not geographic
  std::string reference;            // its coordinate system

  // x and y of a sample's middle.
  std::array<double, 2> place(int column, int row) const;
  // Column and row of a place, counted from the edges; fractions are parts of samples.
  std::array<double, 2> sample(double x, double y) const;
  // The value at a place; NaN outside.
  float at(double x, double y) const;
};

struct RasterRequest {
  int band = 1;
  int every = 1;     // so many samples along each axis become one
  bool mean = true;  // their mean; else the middle one, as of numbers of classes
  std::optional<RasterBounds> within;
  std::size_t mostSamples = 64'000'000;
};

// Throws InputError that names the file and what is wrong: it is absent or damaged, no raster, does not say where it
// lies, has no such band, more samples than are asked for, or none within the bounds.
Raster readRaster(const std::filesystem::path& file, const RasterRequest& request);

// Whether both have the same coordinate system, or one does not say it.
bool sameReference(const Raster& a, const Raster& b);

// How many bands a raster has. Throws as readRaster().
int bandsOf(const std::filesystem::path& file);

}  // namespace scanmill
