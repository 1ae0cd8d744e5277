#include "rasters/raster.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string_view>

#include "base/error.h"
#include "base/file.h"
#include "config/text.h"
#include "rasters/rasters_interface.h"

namespace scanmill {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& what) {
  throw InputError({file.string()}, what);
}

std::unique_ptr<RasterReader> open(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) fail(file, "there is no such file");
  try {
    return moduleOf<RastersModule>().open(file.string());
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", file.string(), e.what()));
  } catch (const std::runtime_error& e) {
    fail(file, fmt::format("is no raster that can be read: {}", e.what()));
  }
}

// Throws InputError if a word below the heading of a text grid (Esri's .asc) is not a number, since GDAL reads it as 0.
// Allowed characters are those of numbers, of "nan", "inf", "1.#IND" and "1.#QNAN", and "*", with which GRASS marks
// missing samples.
void refuseWords(const std::filesystem::path& file) {
  const std::string text = readFile(file);
  std::size_t line = 0;
  bool heading = true;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view row = std::string_view(text).substr(begin, end - begin);
    begin = end + 1;
    ++line;
    const std::size_t first = row.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) continue;
    heading = heading && std::isalpha(static_cast<unsigned char>(row[first])) != 0;
    const std::size_t wrong =
        heading ? std::string_view::npos : row.find_first_not_of(" \t\r0123456789+-.eE*#nNaAiIfFdDqQ");
    if (wrong == std::string_view::npos) continue;
    const std::size_t from = row.find_last_of(" \t", wrong) + 1;  // 0 if no blank comes before the word
    const std::string word(row.substr(from, row.find_first_of(" \t\r", wrong) - from));
    throw InputError(
        {file.string(), static_cast<int>(line)},
        fmt::format("'{}' is no number: a sample that is not known has the value of NODATA_value", word.substr(0, 40)));
  }
}

// Returns {first column, first row, end column, end row} of the samples whose centres lie in the bounds; the end column
// and row are excluded.
std::array<int, 4> windowOf(const Raster& whole, const RasterBounds& within) {
  double left = std::numeric_limits<double>::infinity(), top = left, right = -left, bottom = -left;
  for (const double x : {within[0], within[2]}) {
    for (const double y : {within[1], within[3]}) {
      const auto [c, r] = whole.sample(x, y);
      left = std::min(left, c);
      right = std::max(right, c);
      top = std::min(top, r);
      bottom = std::max(bottom, r);
    }
  }
  const auto clamped = [](double edge, int count) {
    return static_cast<int>(std::clamp(std::round(edge), 0.0, static_cast<double>(count)));
  };
  return {clamped(left, whole.width), clamped(top, whole.height), clamped(right, whole.width),
          clamped(bottom, whole.height)};
}

}  // namespace

std::array<double, 2> Raster::place(int column, int row) const {
  const double c = column + 0.5;
  const double r = row + 0.5;
  return {transform[0] + c * transform[1] + r * transform[2], transform[3] + c * transform[4] + r * transform[5]};
}

std::array<double, 2> Raster::sample(double x, double y) const {
  const double det = transform[1] * transform[5] - transform[2] * transform[4];
  const double dx = x - transform[0];
  const double dy = y - transform[3];
  return {(transform[5] * dx - transform[2] * dy) / det, (transform[1] * dy - transform[4] * dx) / det};
}

float Raster::at(double x, double y) const {
  const auto [c, r] = sample(x, y);
  if (!(c >= 0 && r >= 0 && c < width && r < height)) return std::numeric_limits<float>::quiet_NaN();
  return values[static_cast<std::size_t>(r) * static_cast<std::size_t>(width) + static_cast<std::size_t>(c)];
}

Raster readRaster(const std::filesystem::path& file, const RasterRequest& request) {
  const std::unique_ptr<RasterReader> reader = open(file);
  const RasterHeader header = reader->header();
  if (lowerExtension(file) == ".asc") refuseWords(file);
  if (header.width <= 0 || header.height <= 0) fail(file, "has no samples");
  if (!header.placed) fail(file, "does not say where it lies: it has no geotransform; set it by gdal_edit.py -a_ullr");
  if (request.band > header.bands) fail(file, fmt::format("has {} bands, and no band {}", header.bands, request.band));
  Raster raster;
  raster.width = header.width;
  raster.height = header.height;
  raster.transform = header.transform;
  raster.geographic = header.geographic;
  raster.metresPerUnit = header.metresPerUnit;
  raster.reference = header.reference;
  const auto& t = raster.transform;
  const double det = t[1] * t[5] - t[2] * t[4];
  if (!std::isfinite(det) || det == 0 || !std::isfinite(t[0] + t[3])) fail(file, "has a geotransform that is none");
  std::array<int, 4> window{0, 0, header.width, header.height};
  if (request.within) window = windowOf(raster, *request.within);
  const int across = window[2] - window[0];
  const int down = window[3] - window[1];
  if (across <= 0 || down <= 0) {
    const auto [x, y] = raster.place(0, 0);
    const auto [x2, y2] = raster.place(header.width - 1, header.height - 1);
    fail(file, fmt::format("has no sample there: it reaches from [{:.10g}, {:.10g}] to [{:.10g}, {:.10g}]",
                           std::min(x, x2), std::min(y, y2), std::max(x, x2), std::max(y, y2)));
  }
  raster.width = std::max(across / request.every, 1);
  raster.height = std::max(down / request.every, 1);
  const std::size_t samples = static_cast<std::size_t>(raster.width) * static_cast<std::size_t>(raster.height);
  if (samples > request.mostSamples) {
    fail(file, fmt::format("has {} x {} samples; at most {} are read: take fewer by `every` or `within`", raster.width,
                           raster.height, request.mostSamples));
  }
  // If the window does not divide evenly by `every`, its last columns and rows are left out.
  const int taken = raster.width * std::min(request.every, across);
  const int takenDown = raster.height * std::min(request.every, down);
  const double columnsEach = static_cast<double>(taken) / raster.width;
  const double rowsEach = static_cast<double>(takenDown) / raster.height;
  raster.transform = {t[0] + window[0] * t[1] + window[1] * t[2], t[1] * columnsEach, t[2] * rowsEach,
                      t[3] + window[0] * t[4] + window[1] * t[5], t[4] * columnsEach, t[5] * rowsEach};
  raster.values.resize(samples);
  try {
    reader->read(request.band, {window[0], window[1], taken, takenDown}, raster.width, raster.height, request.mean,
                 raster.values.data());
  } catch (const std::runtime_error& e) {
    fail(file, fmt::format("is damaged: {}", e.what()));
  }
  return raster;
}

bool sameReference(const Raster& a, const Raster& b) {
  return moduleOf<RastersModule>().same(a.reference, b.reference);
}

int bandsOf(const std::filesystem::path& file) {
  return open(file)->header().bands;
}

}  // namespace scanmill
