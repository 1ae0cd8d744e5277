#include "rasters/raster.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <set>
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

// Throws InputError if a text grid (Esri's .asc) does not say where it lies, has a word below its heading that is not a
// number, or does not have `samples` of them: GDAL would place it at [0, 0], and would read 0 for such words and for
// samples that are missing. Allowed characters are those of numbers, of "nan", "inf", "1.#IND" and "1.#QNAN", and "*",
// with which GRASS marks missing samples.
void checkTextGrid(const std::filesystem::path& file, std::size_t samples, LeftOut& leftOut) {
  constexpr std::string_view kBlanks = " \t\r";
  const std::string text = readFile(file);
  std::set<std::string> heading;
  std::size_t line = 0, found = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view row = std::string_view(text).substr(begin, end - begin);
    begin = end + 1;
    ++line;
    while (true) {
      row.remove_prefix(std::min(row.find_first_not_of(kBlanks), row.size()));
      if (row.empty()) break;
      const std::string_view word = row.substr(0, row.find_first_of(kBlanks));
      row.remove_prefix(word.size());
      const bool isNumber = word.find_first_not_of("0123456789+-.,eE*#nNaAiIfFdDqQ") == std::string_view::npos &&
                            std::count_if(word.begin(), word.end(), [](char c) { return c == '.' || c == ','; }) < 2;
      if (!isNumber && found == 0 && std::isalpha(static_cast<unsigned char>(word[0])) != 0) {
        const std::string key = lowerCase(word);
        if (heading.insert(key).second) leftOut.addKeyword(rasterFormat(), key);
        row.remove_prefix(std::min(row.find_first_not_of(kBlanks), row.size()));
        row.remove_prefix(std::min(row.find_first_of(kBlanks), row.size()));
        continue;
      }
      if (!isNumber) {
        throw InputError({file.string(), static_cast<int>(line)},
                         fmt::format("'{}' is no number: a sample that is not known has the value of NODATA_value",
                                     word.substr(0, 40)));
      }
      ++found;
    }
  }
  const auto has = [&](const char* x, const char* y) { return heading.contains(x) && heading.contains(y); };
  if (heading.contains("ncols") && !has("xllcorner", "yllcorner") && !has("xllcenter", "yllcenter")) {
    fail(file, "does not say where it lies: its heading needs xllcorner and yllcorner, or xllcenter and yllcenter");
  }
  if (found != samples) fail(file, fmt::format("has {} samples, but its heading promises {}", found, samples));
}

// Returns the metres per unit of the heights, negative if they are depths.
double metresPerHeight(const std::filesystem::path& file, const RasterHeader& header) {
  struct Unit {
    std::string_view names;
    double metres;
  };
  static constexpr std::array<Unit, 6> kUnits{{{"|m|metre|metres|meter|meters|", 1},
                                               {"|dm|", 0.1},
                                               {"|cm|", 0.01},
                                               {"|mm|", 0.001},
                                               {"|ft|foot|feet|", 0.3048},
                                               {"|us survey foot|us survey feet|ftus|", 1200.0 / 3937}}};
  const std::string& unit = header.bands[0].unit;
  if (!header.heightUnit.empty() && (unit.empty() || unit == header.heightUnit)) return header.metresPerHeight;
  const double sign = header.metresPerHeight < 0 ? -1 : 1;
  if (unit.empty()) {
    if (!header.geographic && header.perUnit != 1) {
      warn(fmt::format(
          "{}: x and y are in units of {:.6g} m, but nothing states the unit of the heights, which count as "
          "metres: if they are feet, say so by 'gdal_edit.py -units \"{}\" {}'",
          file.string(), header.perUnit, header.perUnit == 0.3048 ? "ft" : "US survey foot", file.string()));
    }
    return sign;
  }
  const std::string word = "|" + lowerCase(unit) + "|";
  const auto* const known =
      std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& u) { return u.names.find(word) != u.names.npos; });
  if (known == kUnits.end()) {
    fail(file, fmt::format("has values in '{}', which is no known unit of heights: state it by gdal_edit.py -units "
                           "with \"m\", \"ft\" or \"US survey foot\"",
                           unit));
  }
  return known->metres * sign;
}

// Throws InputError if the bands are no heights.
void expectHeights(const std::filesystem::path& file, const RasterHeader& header, bool placed) {
  if (!header.foreign.empty()) fail(file, fmt::format("is in {}: convert it by gdalwarp -t_srs", header.foreign));
  const std::string& means = header.bands[0].means;
  // Heightmaps of games are often saved as RGB images of grey shades.
  if (means == "Undefined" || means == "Gray" || (means == "Red" && !placed)) return;
  fail(file, fmt::format("holds colours and no heights: GDAL calls its first band '{}'; if it holds heights, say so by "
                         "gdal_translate -colorinterp_1 gray",
                         means));
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

// Fills the raster's values with the means of equal squares or rectangles of the window, times `factor`.
void readMeans(RasterReader& reader, int band, const std::array<int, 4>& window, double factor, Raster& raster) {
  constexpr int kSamplesAtATime = 4'000'000;
  const int across = window[2] / raster.width;
  const int down = window[3] / raster.height;
  const int rowsAtATime = std::max(kSamplesAtATime / window[2], 1);
  std::vector<double> rows;
  std::vector<double> sums(static_cast<std::size_t>(raster.width));
  std::vector<std::uint32_t> counts(sums.size());
  raster.values.reserve(sums.size() * static_cast<std::size_t>(raster.height));
  for (int first = 0; first < window[3]; first += rowsAtATime) {
    const int count = std::min(rowsAtATime, window[3] - first);
    rows.resize(static_cast<std::size_t>(count) * static_cast<std::size_t>(window[2]));
    reader.read(band, {window[0], window[1] + first, window[2], count}, rows.data());
    const double* sample = rows.data();
    for (int row = first + 1; row <= first + count; ++row) {
      for (std::size_t i = 0; i < sums.size(); ++i) {
        for (int k = 0; k < across; ++k, ++sample) {
          if (!std::isfinite(*sample)) continue;
          sums[i] += *sample;
          ++counts[i];
        }
      }
      if (row % down != 0) continue;
      for (std::size_t i = 0; i < sums.size(); ++i) {
        const bool has = counts[i] > 0;
        raster.values.push_back(has ? static_cast<float>(sums[i] / counts[i] * factor)
                                    : std::numeric_limits<float>::quiet_NaN());
      }
      sums.assign(sums.size(), 0);
      counts.assign(counts.size(), 0);
    }
  }
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

const FormatSupport& rasterFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "Rasters of heights, classes and colours",
      ".tif, .tiff, .asc, .hgt, .vrt, .img, .dem",
      {{Read, "ncols nrows cellsize dx dy xllcorner yllcorner xllcenter yllcenter nodata_value",
        "heading of Esri's text grids (.asc), in any case; NODATA_value is -9999 if it is absent; commas may stand for "
        "decimal points"},
       {Read, "north: south: east: west: rows: cols: null: type: multiplier:", "heading of the text grids of GRASS"},
       {Read, "", "heights: the first band; values of 8 to 64 bits, with the scale and offset of the band"},
       {Read, "",
        "holes: the band's value for missing samples, NaN, masks (in the file or in .msk), alpha bands, gaps of "
        "mosaics (.vrt)"},
       {Read, "", "geotransforms, rotated ones and those that run north too, for areas and for points; world files"},
       {Read, "",
        "coordinate systems with x and y in metres, feet or other units of length, or in degrees or grads; .prj "
        "and .aux.xml"},
       {Read, "", "units of heights: the band's unit, else the vertical system's, else metres; depths become heights"},
       {Read, "", "images on heights: the bands called red, green and blue, else the first three or the first"},
       {Unused, "",
        "overviews, statistics, histograms, names and colours of classes, bands of images that are no "
        "colours"},
       {LeftOut, "", "bands behind the first"},
       {LeftOut, "", "further rasters of the file"}}};
  return format;
}

Raster readRaster(const std::filesystem::path& file, const RasterRequest& request) {
  const std::unique_ptr<RasterReader> reader = open(file);
  const RasterHeader header = reader->header();
  if (header.bands.empty() && header.others > 0) {
    fail(file, fmt::format("holds {} rasters: take one of them by gdal_translate", header.others));
  }
  if (header.width <= 0 || header.height <= 0 || header.bands.empty()) fail(file, "has no samples");
  LeftOut leftOut;
  if (lowerExtension(file) == ".asc") {
    checkTextGrid(file, static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height), leftOut);
  }
  if (!header.placed && request.placed) {
    fail(file,
         "does not say where it lies: it has no geotransform; set it by gdal_edit.py -a_ullr, or by gdalwarp if it "
         "has ground control points");
  }
  if (request.band > std::ssize(header.bands)) {
    fail(file, fmt::format("has {} bands, and no band {}", header.bands.size(), request.band));
  }
  const RasterBand& band = header.bands.at(static_cast<std::size_t>(request.band - 1));
  if (band.type.starts_with('C')) fail(file, fmt::format("has complex numbers ({}) and no heights", band.type));
  double metres = 1;
  if (request.use == RasterUse::Heights) {
    expectHeights(file, header, request.placed);
    metres = metresPerHeight(file, header);
  }
  if (request.use != RasterUse::Colors) {
    leftOut.add("bands behind the first",
                static_cast<std::uint64_t>(std::count_if(header.bands.begin() + 1, header.bands.end(),
                                                         [](const RasterBand& b) { return b.means != "Alpha"; })));
  }
  leftOut.add("further rasters of the file", static_cast<std::uint64_t>(header.others));
  leftOut.tell(file.string());
  Raster raster;
  raster.width = header.width;
  raster.height = header.height;
  raster.transform = header.transform;
  raster.geographic = header.geographic;
  raster.perUnit = header.perUnit;
  raster.reference = header.reference;
  raster.placed = header.placed;
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
  if (std::max(samples, static_cast<std::size_t>(across)) > request.mostSamples) {
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
  try {
    readMeans(*reader, request.band, {window[0], window[1], taken, takenDown}, metres, raster);
  } catch (const std::runtime_error& e) {
    fail(file, fmt::format("is damaged: {}", e.what()));
  }
  return raster;
}

bool sameReference(const Raster& a, const Raster& b) {
  return moduleOf<RastersModule>().same(a.reference, b.reference);
}

std::array<int, 3> colorBands(const std::filesystem::path& file) {
  const std::vector<RasterBand> bands = open(file)->header().bands;
  const auto called = [&](std::string_view means) {
    const auto found = std::find_if(bands.begin(), bands.end(), [&](const RasterBand& b) { return b.means == means; });
    return found == bands.end() ? 0 : static_cast<int>(found - bands.begin()) + 1;
  };
  if (called("Palette") != 0)
    fail(file, "has a colour table: replace its numbers by colours with gdal_translate -expand rgb");
  for (const char* other : {"Cyan", "Hue", "YCbCr_Y"}) {
    if (called(other) != 0)
      fail(file, fmt::format("has a band '{}': convert its colours to red, green and blue", other));
  }
  const std::array<int, 3> named{called("Red"), called("Green"), called("Blue")};
  if (named[0] != 0 && named[1] != 0 && named[2] != 0) return named;
  const int alpha = called("Alpha");
  const auto others = static_cast<int>(bands.size()) - (alpha != 0 ? 1 : 0);
  return others >= 3 ? std::array{1, 2, 3} : std::array{1, 1, 1};
}

}  // namespace scanmill
