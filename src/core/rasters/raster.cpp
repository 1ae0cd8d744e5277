#include "rasters/raster.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <limits>
#include <memory>
#include <set>
#include <stdexcept>

#include "base/error.h"
#include "base/file.h"
#include "base/input_budget.h"
#include "base/text_scan.h"
#include "config/text.h"
#include "rasters/rasters_interface.h"

namespace scanmill {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& what) {
  throw InputError({file.string()}, what);
}

std::unique_ptr<RasterReader> open(const std::filesystem::path& file) {
  if (!pathExists(file)) fail(file, "there is no such file");
  try {
    return moduleOf<RastersModule>().open(file.string());
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", file.string(), e.what()));
  } catch (const std::runtime_error& e) {
    fail(file, fmt::format("is no raster that can be read: {}", e.what()));
  }
}

// Checks a text grid (Esri's .asc): GDAL would place one that does not say where it lies at [0, 0], and read 0 for
// samples that are missing and for words that are no numbers.
void checkTextGrid(const std::filesystem::path& file, const RasterHeader& header) {
  constexpr std::array<std::string_view, 10> kHeading{
      "ncols", "nrows", "xllcorner", "yllcorner", "xllcenter", "yllcenter", "cellsize", "dx", "dy", "nodata_value"};
  const std::string text = readFile(file);
  std::string_view rest = text;
  std::set<std::string> heading;
  std::size_t samplesRead = 0;  // 0: still in the heading
  for (std::string_view word = takeWord(rest); !word.empty(); word = takeWord(rest)) {
    const std::string key = samplesRead == 0 ? lowerCase(word) : "";
    if (!key.empty() && std::isalpha(static_cast<unsigned char>(key[0])) != 0 && key != "nan" && key != "inf") {
      heading.insert(key);
      word = takeWord(rest);
      if (std::find(kHeading.begin(), kHeading.end(), key) == kHeading.end()) continue;
    } else {
      ++samplesRead;
    }
    double number = 0;
    if (parseNumber(word, number)) continue;
    const auto line = 1 + std::count(text.data(), word.data(), '\n');
    throw InputError({file.string(), static_cast<int>(line)},
                     fmt::format("'{}' is no number such as 1234.5 or -1.2e3; a sample that is not known has the value "
                                 "of NODATA_value",
                                 word.substr(0, 40)));
  }
  const auto has = [&](const char* x, const char* y) { return heading.contains(x) && heading.contains(y); };
  if (!has("xllcorner", "yllcorner") && !has("xllcenter", "yllcenter")) {
    fail(file, "does not say where it lies: its heading needs xllcorner and yllcorner, or xllcenter and yllcenter");
  }
  const std::size_t samples = static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height);
  if (samplesRead != samples) {
    fail(file, fmt::format("has {} samples, but its heading promises {}", samplesRead, samples));
  }
}

// Refuses or warns of files that GDAL reads otherwise than they are meant.
void checkFiles(const std::filesystem::path& file, const RasterHeader& header) {
  if (header.driver == "AAIGrid") checkTextGrid(file, header);
  if (header.driver == "GRASSASCIIGrid") fail(file, "is a text grid of GRASS: write a GeoTIFF by r.out.gdal");
  for (const std::filesystem::path other : header.files) {
    const std::string ending = lowerExtension(other);
    // GDAL fills the gaps of mosaics in a mosaic with 0.
    if (ending == ".vrt" && other.filename() != file.filename()) {
      fail(file, fmt::format("is a mosaic of mosaics such as {}: build it from their rasters by gdalbuildvrt, or make "
                             "it one raster by gdalwarp -dstnodata -9999",
                             other.string()));
    }
    if (ending != ".prj") continue;
    if (lowerCase(readFile(other)).starts_with("projection")) {
      fail(other,
           "is of Esri's old kind: replace it by well-known text, which `gdalsrsinfo -o wkt_esri EPSG:CODE` prints");
    }
    if (header.system.definition.empty()) {
      warn(fmt::format("{}: is no coordinate system that can be read: x and y of {} count as metres", other.string(),
                       file.string()));
    }
  }
  if (header.driver == "GTiff" && header.system.local) {
    warn(fmt::format("{}: its coordinate system is not known: x and y count as units of {:.6g} m", file.string(),
                     header.system.perUnit));
  }
}

// Returns the metres per unit of length, by its name; nullopt if it is not known.
std::optional<double> metresOf(std::string_view unit) {
  struct Unit {
    std::string_view names;  // without blanks and marks
    double metres;
  };
  static constexpr std::array<Unit, 4> kUnits{
      {{"|m|metre|metres|meter|meters|", 1},
       {"|cm|centimetre|centimeter|", 0.01},
       {"|ft|foot|feet|", 0.3048},
       {"|ussurveyfoot|ussurveyfeet|usfoot|usft|ftus|footus|surveyfoot|", 1200.0 / 3937}}};
  std::string word = "|" + lowerCase(unit) + "|";
  std::erase_if(word, [](char c) { return c != '|' && std::isalnum(static_cast<unsigned char>(c)) == 0; });
  const auto* const known =
      std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& u) { return u.names.find(word) != u.names.npos; });
  return known == kUnits.end() ? std::nullopt : std::optional(known->metres);
}

// Returns the metres per unit of the heights, negative if they are depths.
double metresPerHeight(const std::filesystem::path& file, const RasterHeader& header) {
  const std::string& unit = header.bands[0].unit;
  const CoordinateSystem& system = header.system;
  if (system.perHeight && (unit.empty() || unit == system.heightUnit)) return *system.perHeight;
  const double sign = system.perHeight.value_or(1) < 0 ? -1 : 1;
  if (unit.empty()) {
    if (!system.geographic && system.perUnit != 1) {
      warn(fmt::format(
          "{}: x and y are in units of {:.6g} m, but nothing states the unit of the heights, which count as "
          "metres: if they are feet, say so by 'gdal_edit.py -units \"{}\" {}'",
          file.string(), system.perUnit, system.perUnit == 0.3048 ? "ft" : "US survey foot", file.string()));
    }
    return sign;
  }
  const std::optional<double> metres = metresOf(unit);
  if (metres) return *metres * sign;
  fail(file, fmt::format("has values in '{}', which is no known unit of heights: state it by gdal_edit.py -units "
                         "with \"m\", \"ft\" or \"US survey foot\"",
                         unit));
}

// Throws InputError if the bands are no heights.
void expectHeights(const std::filesystem::path& file, const RasterHeader& header, bool georeferenced) {
  if (!header.system.foreign.empty())
    fail(file, fmt::format("is in {}: convert it by gdalwarp -dstnodata -9999 -t_srs", header.system.foreign));
  const std::string& means = header.bands[0].means;
  // Heightmaps of games are often saved as RGB images of grey shades.
  if (means == "Undefined" || means == "Gray" || (means == "Red" && !georeferenced)) return;
  fail(file, fmt::format("holds colours and no heights: GDAL calls its first band '{}'; if it holds heights, say so by "
                         "gdal_translate -colorinterp_1 gray",
                         means));
}

// Returns a band of real numbers. Throws InputError if the file has none of this number, or is not read at all.
const RasterBand& checkedBand(const std::filesystem::path& file, const RasterHeader& header,
                              const RasterRequest& request) {
  if (header.bands.empty() && header.others > 0) {
    fail(file, fmt::format("holds {} rasters: take one of them by gdal_translate", header.others));
  }
  if (header.width <= 0 || header.height <= 0 || header.bands.empty()) fail(file, "has no samples");
  checkFiles(file, header);
  if (!header.georeferenced && request.georeferenced) {
    fail(file,
         "does not say where it lies: it has no geotransform; set it by gdal_edit.py -a_ullr, or by gdalwarp if it "
         "has ground control points");
  }
  if (request.band > std::ssize(header.bands)) {
    fail(file, fmt::format("has {} bands, and no band {}", header.bands.size(), request.band));
  }
  const RasterBand& band = header.bands.at(static_cast<std::size_t>(request.band - 1));
  if (band.type.starts_with('C')) fail(file, fmt::format("has complex numbers ({}) and no heights", band.type));
  return band;
}

// Warns of heights in a stretched coordinate system, and of samples that look like classes or shades.
void warnOfDoubtfulHeights(const std::filesystem::path& file, const CoordinateSystem& system, const RasterBand& band) {
  if (system.isStretched()) {
    warn(fmt::format(
        "{}: lengths in its coordinate system are {:.4g} times those on the ground at its middle (in Mercator "
        "projections 1/cos(latitude)), heights are not: convert it by 'gdalwarp -dstnodata -9999 -t_srs EPSG:{} {} "
        "utm.tif'",
        file.string(), system.stretch, system.utm, file.string()));
  }
  if (band.type == "Byte" && !band.scaled && band.unit.empty() && !system.perHeight) {
    warn(
        fmt::format("{}: has samples of 8 bits, which count as metres: they are seldom heights, but often classes or "
                    "shades; if they are heights, say so by 'gdal_edit.py -units m'",
                    file.string()));
  }
}

// A rectangle of the file's samples.
struct Window {
  int column = 0, row = 0;  // of its first sample
  int width = 0, height = 0;
};

// Returns the samples whose centres lie in the bounds or, if `partly` is true, those that cover a part of the bounds.
Window windowIn(const RasterGrid& grid, const RasterBounds& bounds, bool partly) {
  double left = std::numeric_limits<double>::infinity(), top = left, right = -left, bottom = -left;
  for (const double x : {bounds[0], bounds[2]}) {
    for (const double y : {bounds[1], bounds[3]}) {
      const auto [column, row] = grid.columnAndRow(x, y);
      left = std::min(left, column);
      right = std::max(right, column);
      top = std::min(top, row);
      bottom = std::max(bottom, row);
    }
  }
  const auto within = [](double edge, int count) { return static_cast<int>(std::clamp(edge, 0.0, double(count))); };
  const int column = within(partly ? std::floor(left) : std::round(left), grid.width);
  const int row = within(partly ? std::floor(top) : std::round(top), grid.height);
  return {column, row, within(partly ? std::ceil(right) : std::round(right), grid.width) - column,
          within(partly ? std::ceil(bottom) : std::round(bottom), grid.height) - row};
}

// Returns the samples that the request asks for, without the last columns and rows that do not fill a square of `every`
// x `every` samples. Throws InputError if there are none, or too many squares.
Window windowOf(const std::filesystem::path& file, const RasterGrid& grid, const RasterRequest& request) {
  const auto& t = grid.transform;
  const double determinant = t[1] * t[5] - t[2] * t[4];
  if (!std::isfinite(determinant) || determinant == 0 || !std::isfinite(t[0] + t[3])) {
    fail(file, "has a geotransform that is none");
  }
  Window window{0, 0, grid.width, grid.height};
  if (request.within) window = windowIn(grid, *request.within, request.use != RasterUse::Heights);
  if (window.width <= 0 || window.height <= 0) {
    const auto [x, y] = grid.centreOf(0, 0);
    const auto [x2, y2] = grid.centreOf(grid.width - 1, grid.height - 1);
    fail(file, fmt::format("has no sample there: it reaches from [{:.10g}, {:.10g}] to [{:.10g}, {:.10g}]",
                           std::min(x, x2), std::min(y, y2), std::max(x, x2), std::max(y, y2)));
  }
  const int columns = std::max(window.width / request.every, 1);
  const int rows = std::max(window.height / request.every, 1);
  const std::size_t squares = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  if (std::max(squares, static_cast<std::size_t>(window.width)) > request.mostSamples) {
    fail(file, fmt::format("has {} x {} samples; at most {} are read: take fewer by `every` or `within`", columns, rows,
                           request.mostSamples));
  }
  window.width = columns * std::min(request.every, window.width);
  window.height = rows * std::min(request.every, window.height);
  return window;
}

// Returns the grid of a window whose squares of `every` x `every` samples are one sample each; a window that is
// narrower or lower than a square has rectangles instead.
Raster reducedGrid(const RasterGrid& whole, const Window& window, int every) {
  Raster grid{whole, {}};
  grid.width = std::max(window.width / every, 1);
  grid.height = std::max(window.height / every, 1);
  const double columnsEach = double(window.width) / grid.width, rowsEach = double(window.height) / grid.height;
  const auto& t = whole.transform;
  grid.transform = {t[0] + window.column * t[1] + window.row * t[2], t[1] * columnsEach, t[2] * rowsEach,
                    t[3] + window.column * t[4] + window.row * t[5], t[4] * columnsEach, t[5] * rowsEach};
  return grid;
}

// Fills the raster's values with the means of the window's squares, times `factor`. Returns true if samples have the
// value `marker`, and all others are above it or all are below it.
bool readMeans(RasterReader& reader, int band, double marker, const Window& window, double factor, Raster& raster) {
  constexpr int kSamplesAtATime = 4'000'000;
  const int columnsEach = window.width / raster.width, rowsEach = window.height / raster.height;  // of a square
  const int rowsAtATime = std::max(kSamplesAtATime / window.width, 1);
  std::vector<double> samples;
  std::vector<double> sums(static_cast<std::size_t>(raster.width));  // by square of a row of squares
  std::vector<std::uint32_t> counts(sums.size());
  double least = marker, greatest = marker;
  bool marked = false;
  for (int row = 0; row < window.height; ++row) {
    const int rowInBlock = row % rowsAtATime;
    if (rowInBlock == 0) {
      const int rows = std::min(rowsAtATime, window.height - row);
      samples.resize(static_cast<std::size_t>(rows) * static_cast<std::size_t>(window.width));
      reader.read(band, {window.column, window.row + row, window.width, rows}, samples.data());
    }
    const double* sample =
        samples.data() + static_cast<std::size_t>(rowInBlock) * static_cast<std::size_t>(window.width);
    for (std::size_t square = 0; square < sums.size(); ++square) {
      for (int column = 0; column < columnsEach; ++column, ++sample) {
        if (!std::isfinite(*sample)) continue;
        marked |= *sample == marker;
        least = std::min(least, *sample);
        greatest = std::max(greatest, *sample);
        sums[square] += *sample;
        ++counts[square];
      }
    }
    if ((row + 1) % rowsEach != 0) continue;
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const double mean = counts[i] > 0 ? sums[i] / counts[i] : std::numeric_limits<double>::quiet_NaN();
      raster.values.push_back(static_cast<float>(mean * factor));
    }
    sums.assign(sums.size(), 0);
    counts.assign(counts.size(), 0);
  }
  return marked && (least == marker || greatest == marker);
}

}  // namespace

std::array<double, 2> RasterGrid::centreOf(int column, int row) const {
  const double c = column + 0.5;
  const double r = row + 0.5;
  return {transform[0] + c * transform[1] + r * transform[2], transform[3] + c * transform[4] + r * transform[5]};
}

std::array<double, 2> RasterGrid::columnAndRow(double x, double y) const {
  const double det = transform[1] * transform[5] - transform[2] * transform[4];
  const double dx = x - transform[0];
  const double dy = y - transform[3];
  return {(transform[5] * dx - transform[2] * dy) / det, (transform[1] * dy - transform[4] * dx) / det};
}

float Raster::valueAt(double x, double y) const {
  const auto [c, r] = columnAndRow(x, y);
  if (!(c >= 0 && r >= 0 && c < width && r < height)) return std::numeric_limits<float>::quiet_NaN();
  return values[static_cast<std::size_t>(r) * static_cast<std::size_t>(width) + static_cast<std::size_t>(c)];
}

std::array<double, 2> Raster::range() const {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const float value : values) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, double{value});
    high = std::max(high, double{value});
  }
  return {low, high};
}

const FormatSupport& rasterFormat() {
  static const FormatSupport format{
      "Rasters of heights, classes and colours",
      ".tif, .tiff, .asc, .hgt, .vrt, .img, .dem",
      {},
      "By GDAL: values of 8 to 64 bits with the band's scale and offset; holes by the band's value, NaN, masks, alpha "
      "bands and gaps of mosaics; geotransforms and world files; coordinate systems in any unit, of .prj and .aux.xml "
      "too; heights in the band's unit, else that of the vertical system, else metres, and depths as heights; bands "
      "called red, green and blue, else the first three or the first. Text grids are Esri's",
      "bands behind the first; further rasters of the file"};
  return format;
}

Raster readRaster(const std::filesystem::path& file, const RasterRequest& request) {
  const std::unique_ptr<RasterReader> reader = open(file);
  const RasterHeader header = reader->header();
  recordFile(file);
  for (const std::filesystem::path other : header.files) recordFile(other);
  const RasterBand& band = checkedBand(file, header, request);
  const bool heights = request.use == RasterUse::Heights;
  if (heights) expectHeights(file, header, request.georeferenced);
  const double factor = heights ? metresPerHeight(file, header) : 1;
  if (heights && request.georeferenced) warnOfDoubtfulHeights(file, header.system, band);
  LeftOut leftOut;
  for (std::size_t k = 1; k < header.bands.size() && request.use != RasterUse::Colors; ++k) {
    if (header.bands[k].means != "Alpha") leftOut.add("bands behind the first");
  }
  leftOut.add("further rasters of the file", static_cast<std::uint64_t>(header.others));
  leftOut.warn(file.string());
  const Window window = windowOf(file, header, request);
  Raster raster = reducedGrid(header, window, request.every);
  try {
    if (readMeans(*reader, request.band, band.marker, window, factor, raster) && heights) {
      warn(
          fmt::format("{}: has samples of -9999: if this value marks missing samples, say so by 'gdal_edit.py "
                      "-a_nodata -9999'",
                      file.string()));
    }
  } catch (const std::runtime_error& e) {
    fail(file, fmt::format("is damaged: {}", e.what()));
  }
  if (request.use == RasterUse::Colors && band.inverted && (band.type == "Byte" || band.type == "UInt16")) {
    const float white = band.type == "Byte" ? 255 : 65535;
    for (float& value : raster.values) value = white - value;
  }
  return raster;
}

CoordinateSystem coordinateSystem(std::string_view definition, double x, double y) {
  return moduleOf<RastersModule>().system(std::string(definition), x, y);
}

CoordinateSystem coordinateSystem(const GeoKeys& keys, double x, double y) {
  return moduleOf<RastersModule>().system(keys, x, y);
}

bool sameReference(const Raster& a, const Raster& b) {
  return moduleOf<RastersModule>().same(a.system.definition, b.system.definition);
}

double shiftBetween(const std::string& reference, const std::string& other, double x, double y) {
  try {
    return reference == other ? 0 : moduleOf<RastersModule>().shift(reference, other, x, y);
  } catch (const Error&) {
    return 0;
  }
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
