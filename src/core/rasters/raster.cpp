#include "rasters/raster.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <limits>
#include <memory>
#include <set>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/input_budget.h"
#include "base/text_scan.h"
#include "config/text.h"
#include "rasters/rasters_interface.h"

namespace scanmill {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& problem) {
  throw InputError({file.string()}, problem);
}

// Opens a raster. Throws InputError if the file is absent or no raster, and Error if GDAL cannot be loaded.
std::unique_ptr<RasterReader> open(const std::filesystem::path& file) {
  if (!pathExists(file)) fail(file, "there is no such file");
  try {
    return moduleOf<RastersModule>().open(file.string());
  } catch (const Error& e) {
    throw Error("{}: {}", file.string(), e.what());
  } catch (const std::runtime_error& e) {
    fail(file, fmt::format("is no raster that can be read: {}", e.what()));
  }
}

// Checks a text grid (Esri's .asc), in which header lines, each a key and a value, come before the samples. Throws
// InputError for a grid without a position, which GDAL would place at [0, 0], and for missing samples and words that
// are no numbers, which GDAL would read as 0.
void checkTextGrid(const std::filesystem::path& file, const RasterHeader& header) {
  constexpr std::array<std::string_view, 10> kHeading{
      "ncols", "nrows", "xllcorner", "yllcorner", "xllcenter", "yllcenter", "cellsize", "dx", "dy", "nodata_value"};
  const std::string text = readFile(file);
  std::string_view unreadText = text;
  std::set<std::string> keys;
  std::size_t samplesRead = 0;
  for (std::string_view word = takeWord(unreadText); !word.empty(); word = takeWord(unreadText)) {
    const std::string key = samplesRead == 0 ? lowerCase(word) : "";
    const bool isKey = std::isalpha(static_cast<unsigned char>(key[0])) != 0 && key != "nan" && key != "inf";
    if (isKey) {
      keys.insert(key);
      word = takeWord(unreadText);
      if (std::ranges::find(kHeading, key) == kHeading.end()) continue;  // the value may be no number
    } else {
      ++samplesRead;
    }
    double number = 0;
    if (parseNumber(word, number)) continue;
    const auto line = 1 + std::count(text.data(), word.data(), '\n');
    throw InputError({file.string(), static_cast<int>(line)},
                     "'{}' is no number such as 1234.5 or -1.2e3; a sample that is not known has the value "
                     "of NODATA_value",
                     word.substr(0, 40));
  }
  const auto hasBoth = [&](const char* x, const char* y) { return keys.contains(x) && keys.contains(y); };
  if (!hasBoth("xllcorner", "yllcorner") && !hasBoth("xllcenter", "yllcenter")) {
    fail(file, "does not say where it lies: its heading needs xllcorner and yllcorner, or xllcenter and yllcenter");
  }
  const std::size_t statedSamples = static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height);
  if (samplesRead != statedSamples) {
    fail(file, fmt::format("has {} samples, but its heading promises {}", samplesRead, statedSamples));
  }
}

// Throws InputError for some files that GDAL is known to misread, and warns of others.
void checkFiles(const std::filesystem::path& file, const RasterHeader& header) {
  if (header.driver == "AAIGrid") checkTextGrid(file, header);
  if (header.driver == "GRASSASCIIGrid") fail(file, "is a text grid of GRASS: write a GeoTIFF by r.out.gdal");
  for (const std::filesystem::path usedFile : header.files) {
    const std::string ending = lowerExtension(usedFile);
    // In a mosaic of mosaics, GDAL fills the gaps of the inner mosaics with 0.
    if (ending == ".vrt" && usedFile.filename() != file.filename()) {
      fail(file, fmt::format("is a mosaic of mosaics such as {}: build it from their rasters by gdalbuildvrt, or make "
                             "it one raster by gdalwarp -dstnodata -9999",
                             usedFile.string()));
    }
    if (ending != ".prj") continue;
    if (lowerCase(readFile(usedFile)).starts_with("projection")) {
      fail(usedFile,
           "is of Esri's old kind: replace it by well-known text, which `gdalsrsinfo -o wkt_esri EPSG:CODE` prints");
    }
    if (header.system.definition.empty()) {
      warn("{}: is no coordinate system that can be read: x and y of {} count as metres", usedFile.string(),
           file.string());
    }
  }
  if (header.driver == "GTiff" && header.system.local) {
    warn("{}: its coordinate system is not known: x and y count as units of {:.6g} m", file.string(),
         header.system.perUnit);
  }
}

// Returns the metres per unit of length, by the unit's name; nullopt for an unknown name.
std::optional<double> metresOf(std::string_view unit) {
  // Names of each unit, between bars, in lower case, without blanks and punctuation; and its length (m).
  static constexpr std::array<std::pair<std::string_view, double>, 4> kUnits{
      {{"|m|metre|metres|meter|meters|", 1},
       {"|cm|centimetre|centimeter|", 0.01},
       {"|ft|foot|feet|", 0.3048},
       {"|ussurveyfoot|ussurveyfeet|usfoot|usft|ftus|footus|surveyfoot|", 1200.0 / 3937}}};
  std::string name = "|" + lowerCase(unit) + "|";
  std::erase_if(name, [](char c) { return c != '|' && std::isalnum(static_cast<unsigned char>(c)) == 0; });
  for (const auto& [names, metres] : kUnits) {
    if (names.find(name) != names.npos) return metres;
  }
  return std::nullopt;
}

// Returns the metres per unit of heights; negative for depths. Takes the band's unit or, if the band has none, the unit
// of the vertical system or, without such a system, the metre. Throws InputError for an unknown unit.
double metresPerHeight(const std::filesystem::path& file, const RasterHeader& header) {
  const std::string& unit = header.bands[0].unit;
  const CoordinateSystem& system = header.system;
  if (system.perHeight && (unit.empty() || unit == system.heightUnit)) return *system.perHeight;
  const double sign = system.perHeight.value_or(1) < 0 ? -1 : 1;
  if (unit.empty()) {
    if (!system.geographic && system.perUnit != 1) {
      warn(
          "{}: x and y are in units of {:.6g} m, but nothing states the unit of the heights, which count as "
          "metres: if they are feet, say so by 'gdal_edit.py -units \"{}\" {}'",
          file.string(), system.perUnit, system.perUnit == 0.3048 ? "ft" : "US survey foot", file.string());
    }
    return sign;
  }
  const std::optional<double> metres = metresOf(unit);
  if (metres) return *metres * sign;
  fail(file, fmt::format("has values in '{}', which is no known unit of heights: state it by gdal_edit.py -units "
                         "with \"m\", \"ft\" or \"US survey foot\"",
                         unit));
}

// Throws InputError if the first band holds colours, or if x and y cannot be used.
void requireHeights(const std::filesystem::path& file, const RasterHeader& header, bool georeferenced) {
  if (!header.system.foreign.empty())
    fail(file, fmt::format("is in {}: convert it by gdalwarp -dstnodata -9999 -t_srs", header.system.foreign));
  const std::string& means = header.bands[0].means;
  // Heightmaps of games are often saved as RGB images of grey shades.
  if (means == "Undefined" || means == "Gray" || (means == "Red" && !georeferenced)) return;
  fail(file, fmt::format("holds colours and no heights: GDAL calls its first band '{}'; if it holds heights, say so by "
                         "gdal_translate -colorinterp_1 gray",
                         means));
}

// Returns the requested band. Throws InputError if the file has no such band or cannot be used, or if the band holds
// complex numbers.
const RasterBand& requestedBand(const std::filesystem::path& file, const RasterHeader& header,
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
    warn(
        "{}: lengths in its coordinate system are {:.4g} times those on the ground at its middle (in Mercator "
        "projections 1/cos(latitude)), heights are not: convert it by 'gdalwarp -dstnodata -9999 -t_srs EPSG:{} {} "
        "utm.tif'",
        file.string(), system.stretch, system.utm, file.string());
  }
  if (band.type == "Byte" && !band.scaled && band.unit.empty() && !system.perHeight) {
    warn(
        "{}: has samples of 8 bits, which count as metres: they are seldom heights, but often classes or "
        "shades; if they are heights, say so by 'gdal_edit.py -units m'",
        file.string());
  }
}

// A rectangle of the file's samples.
struct Window {
  int column = 0, row = 0;  // column and row of the first sample
  int width = 0, height = 0;
};

// Returns the window of the samples in the bounds, cut off at the raster's edges: for heights, samples whose centres
// are in the bounds; for classes and colours, all samples that overlap the bounds.
Window windowIn(const RasterGrid& grid, const RasterBounds& bounds, RasterUse use) {
  const auto [x0, y0, x1, y1] = bounds;
  const std::array corners{grid.columnAndRow(x0, y0), grid.columnAndRow(x0, y1), grid.columnAndRow(x1, y0),
                           grid.columnAndRow(x1, y1)};
  std::array<int, 2> first{}, end{};  // column and row
  for (const std::size_t axis : {std::size_t{0}, std::size_t{1}}) {
    const auto atAxis = [&](const std::array<double, 2>& corner) { return corner[axis]; };
    const double low = std::ranges::min(corners, {}, atAxis)[axis], high = std::ranges::max(corners, {}, atAxis)[axis];
    const bool byCentre = use == RasterUse::Heights;
    const double samples = axis == 0 ? grid.width : grid.height;
    first[axis] = static_cast<int>(std::clamp(byCentre ? std::round(low) : std::floor(low), 0.0, samples));
    end[axis] = static_cast<int>(std::clamp(byCentre ? std::round(high) : std::ceil(high), 0.0, samples));
  }
  return {.column = first[0], .row = first[1], .width = end[0] - first[0], .height = end[1] - first[1]};
}

// Returns the window that the request asks for, without the last columns and rows that do not fill a square of `every`
// x `every` samples. A window with fewer than `every` columns or rows keeps them all. Throws InputError for an unusable
// geotransform, a window without samples, and a result with too many samples.
Window windowOf(const std::filesystem::path& file, const RasterGrid& grid, const RasterRequest& request) {
  constexpr std::size_t kMostSamples = 64'000'000;  // largest number of samples in the result
  const auto& t = grid.transform;
  const double determinant = t[1] * t[5] - t[2] * t[4];
  if (!std::isfinite(determinant) || determinant == 0 || !std::isfinite(t[0] + t[3])) {
    fail(file, "has a geotransform that is none");
  }
  Window window{.width = grid.width, .height = grid.height};
  if (request.within) window = windowIn(grid, *request.within, request.use);
  if (window.width <= 0 || window.height <= 0) {
    const auto [x0, y0] = grid.centreOf(0, 0);
    const auto [x1, y1] = grid.centreOf(grid.width - 1, grid.height - 1);
    fail(file, fmt::format("has no sample there: it reaches from [{:.10g}, {:.10g}] to [{:.10g}, {:.10g}]",
                           std::min(x0, x1), std::min(y0, y1), std::max(x0, x1), std::max(y0, y1)));
  }
  const int columns = std::max(window.width / request.every, 1);
  const int rows = std::max(window.height / request.every, 1);
  const std::size_t squares = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  if (std::max(squares, static_cast<std::size_t>(window.width)) > kMostSamples) {
    fail(file, fmt::format("has {} x {} samples; at most {} are read: take fewer by `every` or `within`", columns, rows,
                           kMostSamples));
  }
  window.width = columns * std::min(request.every, window.width);
  window.height = rows * std::min(request.every, window.height);
  return window;
}

// Returns the grid of a window in which each square of `every` x `every` samples is one sample. A window with fewer
// than `every` columns or rows is one sample wide or high.
Raster reducedGrid(const RasterGrid& fileGrid, const Window& window, int every) {
  Raster grid{fileGrid, {}};
  grid.width = std::max(window.width / every, 1);
  grid.height = std::max(window.height / every, 1);
  const double columnsPerSquare = double(window.width) / grid.width,
               rowsPerSquare = double(window.height) / grid.height;
  const auto& t = fileGrid.transform;
  const auto [x, y] = fileGrid.pointAt(window.column, window.row);
  grid.transform = {x, t[1] * columnsPerSquare, t[2] * rowsPerSquare, y, t[4] * columnsPerSquare, t[5] * rowsPerSquare};
  return grid;
}

// Fills `raster`, a reducedGrid() of the window, with the mean of each square of the window, times `factor`. Returns
// true if `marker` is the least or the greatest value in the window: it then probably marks missing samples.
bool readMeans(RasterReader& reader, int band, double marker, const Window& window, double factor, Raster& raster) {
  constexpr int kSamplesPerBlock = 4'000'000;  // 32 MB; a block consists of complete rows
  const int columnsPerSquare = window.width / raster.width, rowsPerSquare = window.height / raster.height;
  const int rowsPerBlock = std::max(kSamplesPerBlock / window.width, 1);
  std::vector<double> block;
  struct Square {
    double sum = 0;
    std::uint32_t count = 0;  // number of samples with a value
  };
  std::vector<Square> squares(static_cast<std::size_t>(raster.width));  // squares of one row
  double least = marker, greatest = marker;
  bool hasMarker = false;
  for (int row = 0; row < window.height; ++row) {
    const int rowInBlock = row % rowsPerBlock;
    if (rowInBlock == 0) {
      const int rows = std::min(rowsPerBlock, window.height - row);
      block.resize(static_cast<std::size_t>(rows) * static_cast<std::size_t>(window.width));
      reader.read(band, {window.column, window.row + row, window.width, rows}, block.data());
    }
    const double* sample = block.data() + static_cast<std::size_t>(rowInBlock) * static_cast<std::size_t>(window.width);
    for (Square& square : squares) {
      for (int column = 0; column < columnsPerSquare; ++column, ++sample) {
        if (!std::isfinite(*sample)) continue;
        hasMarker |= *sample == marker;
        least = std::min(least, *sample);
        greatest = std::max(greatest, *sample);
        square.sum += *sample;
        ++square.count;
      }
    }
    if ((row + 1) % rowsPerSquare != 0) continue;
    for (Square& square : squares) {
      const double mean = square.count > 0 ? square.sum / square.count : std::numeric_limits<double>::quiet_NaN();
      raster.values.push_back(static_cast<float>(mean * factor));
      square = {};
    }
  }
  return hasMarker && (least == marker || greatest == marker);
}

}  // namespace

std::array<double, 2> RasterGrid::columnAndRow(double x, double y) const {
  const auto& t = transform;
  const double determinant = t[1] * t[5] - t[2] * t[4];
  const double dx = x - t[0], dy = y - t[3];
  return {(t[5] * dx - t[2] * dy) / determinant, (t[1] * dy - t[4] * dx) / determinant};
}

float Raster::valueAt(double x, double y) const {
  const auto [column, row] = columnAndRow(x, y);
  if (!(column >= 0 && row >= 0 && column < width && row < height)) return std::numeric_limits<float>::quiet_NaN();
  return values[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)];
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

const FormatSupport kRasterFormat{
    "Rasters of heights, classes and colours", ".tif, .tiff, .asc, .hgt, .vrt, .img, .dem",
    "By GDAL: values of 8 to 64 bits with the band's scale and offset; holes by the band's value, NaN, masks, alpha "
    "bands and gaps of mosaics; geotransforms and world files; coordinate systems in any unit, of .prj and .aux.xml "
    "too; heights in the band's unit, else that of the vertical system, else metres, and depths as heights; bands "
    "called red, green and blue, else the first three or the first. Text grids are Esri's",
    "bands behind the first; further rasters of the file"};

Raster readRaster(const std::filesystem::path& file, const RasterRequest& request) {
  const std::unique_ptr<RasterReader> reader = open(file);
  const RasterHeader header = reader->header();
  recordFile(file);
  for (const std::filesystem::path usedFile : header.files) recordFile(usedFile);
  const RasterBand& band = requestedBand(file, header, request);
  const bool isOfHeights = request.use == RasterUse::Heights;
  if (isOfHeights) requireHeights(file, header, request.georeferenced);
  const double factor = isOfHeights ? metresPerHeight(file, header) : 1;
  if (isOfHeights && request.georeferenced) warnOfDoubtfulHeights(file, header.system, band);
  LeftOut leftOut;
  for (std::size_t k = 1; k < header.bands.size() && request.use != RasterUse::Colors; ++k) {
    if (header.bands[k].means != "Alpha") leftOut.add("bands behind the first");
  }
  leftOut.add("further rasters of the file", static_cast<std::uint64_t>(header.others));
  leftOut.warn(file.string());
  const Window window = windowOf(file, header, request);
  Raster raster = reducedGrid(header, window, request.every);
  try {
    if (readMeans(*reader, request.band, band.marker, window, factor, raster) && isOfHeights) {
      warn("{}: has samples of -9999: if this value marks missing samples, say so by 'gdal_edit.py -a_nodata -9999'",
           file.string());
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
  constexpr int kNone = 0;
  const auto numberOf = [&](std::string_view meaning) {
    const auto band = std::ranges::find(bands, meaning, &RasterBand::means);
    return band == bands.end() ? kNone : static_cast<int>(band - bands.begin()) + 1;
  };
  if (numberOf("Palette") != kNone)
    fail(file, "has a colour table: replace its numbers by colours with gdal_translate -expand rgb");
  for (const char* foreignColor : {"Cyan", "Hue", "YCbCr_Y"}) {
    if (numberOf(foreignColor) != kNone)
      fail(file, fmt::format("has a band '{}': convert its colours to red, green and blue", foreignColor));
  }
  const std::array<int, 3> rgb{numberOf("Red"), numberOf("Green"), numberOf("Blue")};
  if (std::ranges::find(rgb, kNone) == rgb.end()) return rgb;
  const auto colors = std::ssize(bands) - (numberOf("Alpha") != kNone ? 1 : 0);
  return colors >= 3 ? std::array{1, 2, 3} : std::array{1, 1, 1};
}

}  // namespace scanmill
