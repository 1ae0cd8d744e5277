#include "assets/worlds/heightmap.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "assets/meshes/asset_parts.h"
#include "assets/worlds/solids.h"
#include "config/text.h"
#include "rasters/raster.h"

namespace scanmill {
namespace {

bool isImage(const Raster& raster, const std::filesystem::path& file) {
  const std::string suffix = lowerExtension(file);
  return !raster.placed || suffix == ".png" || suffix == ".jpg" || suffix == ".jpeg";
}

// Returns the size of a heightmap (m) whose heights reach from `low` to `high`.
Vec3d sizeOf(const XmlNode& shape, const Raster& raster, bool image, double low, double high) {
  if (shape.child("size") != nullptr) return sizesOf(shape, "size");
  if (image) return {1, 1, 1};
  if (raster.geographic) shape.fail("has no <size>, which a raster in degrees needs");
  const auto& t = raster.transform;
  return {raster.width * std::hypot(t[1], t[4]) * raster.perUnit,
          raster.height * std::hypot(t[2], t[5]) * raster.perUnit, high - low};
}

// Returns the value between a and b at t, 0 to 1. A value that is missing (NaN) does not reach the other's place.
double between(double a, double b, double t) {
  return t == 0 ? a : a + t * (b - a);
}

}  // namespace

Mesh heightmapOf(const XmlNode& shape, const std::filesystem::path& file) {
  RasterRequest request;
  request.placed = false;
  const Raster raster = readRaster(file, request);
  const bool image = isImage(raster, file);
  const double step = numbersIn(shape, shape.textOf("sampling", "1"), 1).front();
  if (!(step >= 1 && step <= 64 && step == std::floor(step))) {
    shape.fail(fmt::format("has the sampling {:g}, but it must be a whole number from 1 to 64", step));
  }
  if (raster.width < 2 || raster.height < 2) {
    shape.fail(fmt::format("names '{}', which has not two rows and two columns of samples", file.string()));
  }
  if (2 * raster.width * step * raster.height * step > static_cast<double>(kMostTriangles)) {
    shape.fail(fmt::format("has {} x {} samples, {:g} a pixel and direction: lower its <sampling>", raster.width,
                           raster.height, step));
  }
  const int every = static_cast<int>(step);
  const int columns = (raster.width - 1) * every + 1, rows = (raster.height - 1) * every + 1;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const float value : raster.values) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, double{value});
    high = std::max(high, double{value});
  }
  if (image) low = 0;
  const Vec3d size = sizeOf(shape, raster, image, low, high);
  const Vec3d middle = vectorIn(shape, shape.textOf("pos", "0 0 0"));
  const double scale = high > low ? size.z / (high - low) : 0;
  const auto value = [&](int column, int row) {
    return double{raster.values[static_cast<std::size_t>(row) * static_cast<std::size_t>(raster.width) +
                                static_cast<std::size_t>(column)]};
  };
  Mesh mesh;
  for (int row = 0; row < rows; ++row) {
    const int above = row / every, below = std::min(above + 1, raster.height - 1);
    const double down = static_cast<double>(row % every) / every;
    for (int column = 0; column < columns; ++column) {
      const int left = column / every, right = std::min(left + 1, raster.width - 1);
      const double along = static_cast<double>(column % every) / every;
      const double height = between(between(value(left, above), value(right, above), along),
                                    between(value(left, below), value(right, below), along), down);
      mesh.positions.push_back(
          Vec3f(middle + Vec3d{size.x * (static_cast<double>(column) / (columns - 1) - 0.5),
                               size.y * (0.5 - static_cast<double>(row) / (rows - 1)), (height - low) * scale}));
    }
  }
  const auto index = [&](int column, int row) { return static_cast<std::uint32_t>(row * columns + column); };
  for (int row = 0; row + 1 < rows; ++row) {
    for (int column = 0; column + 1 < columns; ++column) {
      const std::array<std::uint32_t, 4> v{index(column, row), index(column, row + 1), index(column + 1, row + 1),
                                           index(column + 1, row)};
      if (std::any_of(v.begin(), v.end(), [&](std::uint32_t i) { return !isFinite(mesh.positions[i]); })) continue;
      mesh.triangles.push_back({v[0], v[1], v[2]});
      mesh.triangles.push_back({v[0], v[2], v[3]});
    }
  }
  return mesh;
}

}  // namespace scanmill
