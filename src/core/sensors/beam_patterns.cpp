#include "sensors/beam_patterns.h"

#include <algorithm>
#include <cmath>

#include "sensors/text_table.h"

namespace scanmill {
namespace {

// Throws InputError if a table of beams has an unknown column, or lacks a column that it needs.
void checkColumns(const TextTable& table) {
  table.expectOnly({"azimuth_deg", "elevation_deg", "zenith_deg", "ring", "column", "origin_x_m", "origin_y_m",
                    "origin_z_m", "time_s", "time_ms", "time_us", "time_ns"});
  table.require("azimuth_deg");
  if (table.has("elevation_deg") == table.has("zenith_deg")) {
    throw InputError(table.head(), "the table needs one of the columns elevation_deg and zenith_deg");
  }
  if (table.has("ring") != table.has("column"))
    throw InputError(table.head(), "the table has only one of the columns ring and column: give both or none");
}

struct BeamRow {
  double azimuth, elevation;  // rad
  double time;                // s since the start of the revolution
  Vec3f origin;               // m
  std::uint32_t ring, column;
  Location where;
};

std::uint32_t toIndex(double number, const Location& where) {
  if (number != std::floor(number)) throw InputError(where, "ring and column must be whole numbers");
  return static_cast<std::uint32_t>(number);
}

// Returns a row of the table. Without a column `ring`, row k is column k of the only ring. Missing columns are 0.
BeamRow readRow(const TextTable& table, std::size_t row) {
  const auto number = [&](const char* name, Range range) { return table.number(row, name, range); };
  const auto origin = [&](const char* name) { return static_cast<float>(number(name, {-10, 10})); };
  const Location& where = table.where(row);
  const double elevation =
      table.has("zenith_deg") ? 90 - number("zenith_deg", {0, 180}) : number("elevation_deg", {-90, 90});
  return {
      .azimuth = radians(number("azimuth_deg", {-360, 360})),
      .elevation = radians(elevation),
      .time = table.time(row, {0, 100}),
      .origin = {origin("origin_x_m"), origin("origin_y_m"), origin("origin_z_m")},
      .ring = toIndex(number("ring", {0, kMostRings - 1}), where),
      .column =
          table.has("ring") ? toIndex(number("column", {0, kMostColumns - 1}), where) : static_cast<std::uint32_t>(row),
      .where = where,
  };
}

// Returns the beams sorted by ring and column. `rows`: as many rows as rings * `columns`. Throws InputError if two of
// them have the same ring and column.
ListedBeams sortedBeams(const std::vector<BeamRow>& rows, std::uint32_t columns) {
  std::vector<const BeamRow*> sorted(rows.size());
  for (const BeamRow& row : rows) {
    const BeamRow*& beam = sorted[std::size_t{row.ring} * columns + row.column];
    if (beam != nullptr) {
      throw InputError(row.where, "has ring {}, column {} of an earlier line: give each beam one line", row.ring,
                       row.column);
    }
    beam = &row;
  }
  ListedBeams beams;
  for (const BeamRow* const row : sorted) {
    beams.azimuth.push_back(row->azimuth);
    beams.elevation.push_back(row->elevation);
    beams.time.push_back(row->time);
    beams.origin.push_back(row->origin);
  }
  if (std::ranges::all_of(beams.origin, [](const Vec3f& o) { return o == Vec3f{}; })) beams.origin.clear();
  return beams;
}

}  // namespace

std::vector<double> scaledBy(double factor, std::vector<double> values) {
  for (double& value : values) value *= factor;
  return values;
}

ListedSensor readListedBeams(const std::filesystem::path& file) {
  const TextTable table(file);
  checkColumns(table);
  std::vector<BeamRow> rows;
  ListedSensor sensor{.rings = 1, .columns = 0, .beams = {}};
  for (std::size_t row = 0; row < table.size(); ++row) {
    rows.push_back(readRow(table, row));
    sensor.rings = std::max(sensor.rings, rows.back().ring + 1);
    sensor.columns = std::max(sensor.columns, rows.back().column + 1);
  }
  if (rows.size() != std::size_t{sensor.rings} * sensor.columns || sensor.columns > kMostColumns) {
    throw InputError({file.string()},
                     "has {} beams, but {} rings of {} columns (at most {}) need one line for each beam: a "
                     "file with the beams of several revolutions must be cut to those of one",
                     rows.size(), sensor.rings, sensor.columns, kMostColumns);
  }
  sensor.beams = sortedBeams(rows, sensor.columns);
  const std::vector<double> starts = sensor.beams.columnStarts(sensor.columns);
  for (std::uint32_t c = 1; c < sensor.columns; ++c) {
    if (starts[c] >= starts[c - 1]) continue;
    throw InputError({file.string()}, "column {} fires before column {}: columns must fire in their order", c, c - 1);
  }
  return sensor;
}

ListedBeams flashBeams(double azimuth, double field, bool clockwise, std::uint32_t columns,
                       const std::vector<double>& elevation) {
  ListedBeams beams;
  for (const double middleElevation : elevation) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      // The pixel lies on a plane at distance 1, `left` to the left of the axis, at the height tan(middleElevation).
      const double left =
          columns == 1 ? 0 : std::tan(field / 2) * (2.0 * column / (columns - 1) - 1) * (clockwise ? -1 : 1);
      beams.azimuth.push_back(azimuth + std::atan(left));
      beams.elevation.push_back(std::atan2(std::tan(middleElevation), std::hypot(1, left)));
      beams.time.push_back(0);
    }
  }
  return beams;
}

namespace {

constexpr Range kTurnsHz{-1e4, 1e4};
constexpr Range kPhasesDeg{-360, 360};

// Reads laser_azimuth_deg and laser_elevation_deg, both optional lists. Throws InputError if they differ in length.
void readLaserDeflections(Fields& f, Rosette& rosette) {
  if (f.has("laser_azimuth_deg")) rosette.left = scaledBy(radians(1), f.numbers("laser_azimuth_deg", {-60, 60}));
  if (f.has("laser_elevation_deg")) rosette.up = scaledBy(radians(1), f.numbers("laser_elevation_deg", {-60, 60}));
  if (rosette.left.empty()) rosette.left.resize(rosette.up.size());
  if (rosette.up.empty()) rosette.up.resize(rosette.left.size());
  if (rosette.left.size() == rosette.up.size()) return;
  throw InputError(f.where(), "laser_azimuth_deg has {} angles, but laser_elevation_deg has {}", rosette.left.size(),
                   rosette.up.size());
}

}  // namespace

Rosette readRosette(const Value& value) {
  constexpr std::size_t kMostPrisms = 4;
  Fields f(value, "rosette");
  Rosette rosette;
  rosette.speed = scaledBy(2 * kPi, f.numbers("turns_hz", kTurnsHz));
  const std::size_t prisms = rosette.speed.size();
  if (prisms < 1 || prisms > kMostPrisms) {
    throw InputError(f.require("turns_hz").where, "turns_hz must be one to four frequencies, such as [121.6, -77.7]");
  }
  const auto perPrism = [&](const char* key, Range range) {
    std::vector<double> values = f.numbers(key, range);
    if (values.size() == prisms) return values;
    throw InputError(f.require(key).where, "{} must be {} numbers, one for each prism of turns_hz", key, prisms);
  };
  if (f.has("deflection_deg") == f.has("field_deg")) {
    throw InputError(value.where, "a rosette needs either field_deg or, for unequal prisms, deflection_deg");
  }
  rosette.angle =
      f.has("deflection_deg")
          ? perPrism("deflection_deg", {0, 85})
          : std::vector<double>(prisms, f.number("field_deg", {0.01, 170}) / 2 / static_cast<double>(prisms));
  rosette.angle = scaledBy(radians(1), std::move(rosette.angle));
  rosette.phase =
      f.has("phase_deg") ? scaledBy(radians(1), perPrism("phase_deg", kPhasesDeg)) : std::vector<double>(prisms, 0);
  readLaserDeflections(f, rosette);
  if (const Value* mirror = f.find("mirror")) {
    Fields m(*mirror, "mirror");
    rosette.mirror = {.tilt = radians(m.number("tilt_deg", {0, 90})),
                      .speed = m.number("turns_hz", kTurnsHz) * 2 * kPi,
                      .phase = radians(m.number("phase_deg", kPhasesDeg, 0))};
    m.finish();
  }
  f.finish();
  return rosette;
}

RasterScan readRasterScan(const Value& value) {
  Fields f(value, "raster");
  RasterScan raster{.zones = f.numbers("zones_deg", {-180, 180})};
  if (raster.zones.empty()) {
    throw InputError(value.where, "zones_deg must be the azimuths of the zones' middles, such as [24, 0, -24]");
  }
  raster.zones = scaledBy(radians(1), std::move(raster.zones));
  raster.width = radians(f.number("width_deg", {0.01, 180}));
  raster.top = radians(f.number("top_deg", {-90, 90}));
  raster.bottom = radians(f.number("bottom_deg", {-90, 90}));
  if (raster.top <= raster.bottom) throw InputError(value.where, "raster: top_deg must be above bottom_deg");
  raster.lineTime = f.number("line_us", {0, 1e8}, 0) * 1e-6;
  raster.lines = static_cast<std::uint32_t>(f.integer("lines", 2, kMostColumns / 2));
  raster.alternate = f.boolean("alternate", false);
  f.finish();
  return raster;
}

ListedBeams rasterBeams(const RasterScan& raster, std::uint32_t columns, double period) {
  const std::uint32_t beamsPerLine = columns / raster.lines;
  const double linePeriod = period / raster.lines;  // s, from the start of a line to the start of the next line
  const double timeStep = raster.lineTime > 0 ? std::min(raster.lineTime, linePeriod) / (beamsPerLine - 1)
                                              : linePeriod / beamsPerLine;  // s, from beam to beam
  ListedBeams beams;
  for (const double zone : raster.zones) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const std::uint32_t line = column / beamsPerLine;
      const std::uint32_t beamInLine = column % beamsPerLine;
      const double angleFromFirst = raster.width * beamInLine / (beamsPerLine - 1);
      const bool rightToLeft = raster.alternate && line % 2 == 1;
      beams.azimuth.push_back(zone + (raster.width / 2 - angleFromFirst) * (rightToLeft ? -1 : 1));
      beams.elevation.push_back(std::lerp(raster.top, raster.bottom, static_cast<double>(line) / (raster.lines - 1)));
      beams.time.push_back(line * linePeriod + beamInLine * timeStep);
    }
  }
  return beams;
}

LineScan readLineScan(const Value& value, double period) {
  Fields f(value, "lines");
  LineScan scan;
  f.require("mirror");
  const std::string mirror = f.choice("mirror", {"rotating", "oscillating", "palmer"}, "");
  if (mirror == "oscillating") scan.mirror = LineScan::Mirror::Oscillating;
  if (mirror == "palmer") scan.mirror = LineScan::Mirror::Palmer;
  const double field = f.number("field_deg", {0.01, mirror == "rotating" ? 360.0 : 170.0});
  scan.field = radians(field);
  const double lines = f.number("rate_hz", {0.01, 1e5}) * period;
  const double unit = mirror == "oscillating" ? 2 : 1;  // an oscillation has two lines
  if (lines < unit || std::abs(lines / unit - std::round(lines / unit)) > 1e-6) {
    throw InputError(f.require("rate_hz").where,
                     "a frame would have {:.6g} lines, but needs a whole number{}: choose the sensor's rate_hz, the "
                     "frames a second, so that it divides the lines a second",
                     lines, unit == 2 ? " of pairs, there and back" : "");
  }
  scan.lines = static_cast<std::uint32_t>(std::lround(lines));
  const double linePeriod = period / scan.lines;
  scan.lineTime = mirror == "rotating" ? linePeriod * field / 360 : linePeriod;
  if (f.has("line_us")) scan.lineTime = f.number("line_us", {1e-3, linePeriod * 1e6}) * 1e-6;
  f.finish();
  return scan;
}

ListedBeams lineBeams(const LineScan& scan, std::uint32_t columns, double period) {
  ListedBeams beams;
  for (std::uint32_t column = 0; column < columns; ++column) {
    const double lines = static_cast<double>(column) * scan.lines / columns;  // since the start of the frame
    const double line = std::floor(lines);
    const double inLine = lines - line;          // from 0 at the start of the line
    double nadir = scan.field * (0.5 - inLine);  // rad, from -z to the left
    double azimuth = kPi / 2;                    // rad, of the side to which the beam is deflected
    if (scan.mirror == LineScan::Mirror::Oscillating) nadir = scan.field / 2 * std::cos(kPi * lines);
    if (scan.mirror == LineScan::Mirror::Palmer) {
      nadir = scan.field / 2;
      azimuth -= 2 * kPi * inLine;
    }
    beams.azimuth.push_back(azimuth);
    beams.elevation.push_back(nadir - kPi / 2);
    beams.time.push_back(line * (period / scan.lines) + inLine * scan.lineTime);
  }
  return beams;
}

}  // namespace scanmill
