#include "sensors/beam_patterns.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "sensors/text_table.h"

namespace scanmill {
namespace {

constexpr std::uint32_t kMostRings = 4096;
constexpr std::uint32_t kMostColumns = 65536;

// Checks the columns of a table of beams.
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

struct Row {
  double azimuth, elevation, time;
  Vec3f origin;
  std::uint32_t ring, column;
  Location where;
};

std::uint32_t countOf(double number, const Location& where) {
  if (number != std::floor(number)) throw InputError(where, "ring and column must be whole numbers");
  return static_cast<std::uint32_t>(number);
}

// Returns a row of the table. Without rings, the rows are the columns of one ring.
Row rowOf(const TextTable& table, std::size_t i) {
  const auto number = [&](const char* name, Range range) { return table.number(i, name, range); };
  const auto origin = [&](const char* name) { return static_cast<float>(number(name, {-10, 10})); };
  const Location& where = table.where(i);
  const double elevation =
      table.has("zenith_deg") ? 90 - number("zenith_deg", {0, 180}) : number("elevation_deg", {-90, 90});
  return {radians(number("azimuth_deg", {-360, 360})),
          radians(elevation),
          table.time(i, {0, 100}),
          {origin("origin_x_m"), origin("origin_y_m"), origin("origin_z_m")},
          countOf(number("ring", {0, kMostRings - 1}), where),
          table.has("ring") ? countOf(number("column", {0, kMostColumns - 1}), where) : static_cast<std::uint32_t>(i),
          where};
}

// Returns the beams by ring and column. Throws InputError if two rows have the same ring and column.
ListedBeams inOrder(const std::vector<Row>& rows, std::uint32_t columns) {
  ListedBeams beams;
  beams.azimuth.resize(rows.size());
  beams.elevation.resize(rows.size());
  beams.time.resize(rows.size());
  beams.origin.resize(rows.size());
  std::vector<bool> isSet(rows.size());
  for (const Row& row : rows) {
    const std::size_t beam = std::size_t{row.ring} * columns + row.column;
    if (isSet[beam]) {
      throw InputError(row.where, fmt::format("has ring {}, column {} of an earlier line: give each beam one line",
                                              row.ring, row.column));
    }
    isSet[beam] = true;
    beams.azimuth[beam] = row.azimuth;
    beams.elevation[beam] = row.elevation;
    beams.time[beam] = row.time;
    beams.origin[beam] = row.origin;
  }
  if (std::ranges::all_of(beams.origin, [](const Vec3f& o) { return o == Vec3f{}; })) beams.origin.clear();
  return beams;
}

}  // namespace

ListedSensor readListedBeams(const std::filesystem::path& file) {
  const TextTable table(file);
  checkColumns(table);
  std::vector<Row> rows;
  ListedSensor sensor{1, 0, {}};
  for (std::size_t i = 0; i < table.size(); ++i) {
    rows.push_back(rowOf(table, i));
    sensor.rings = std::max(sensor.rings, rows.back().ring + 1);
    sensor.columns = std::max(sensor.columns, rows.back().column + 1);
  }
  const std::size_t beams = std::size_t{sensor.rings} * sensor.columns;
  if (rows.size() != beams || sensor.columns > kMostColumns) {
    throw InputError({file.string()},
                     fmt::format("has {} beams, but {} rings of {} columns (at most {}) need one line for each beam: a "
                                 "file with the beams of several revolutions must be cut to those of one",
                                 rows.size(), sensor.rings, sensor.columns, kMostColumns));
  }
  sensor.beams = inOrder(rows, sensor.columns);
  const std::vector<double> starts = sensor.beams.columnStarts(sensor.columns);
  for (std::uint32_t c = 1; c < sensor.columns; ++c) {
    if (starts[c] >= starts[c - 1]) continue;
    throw InputError({file.string()},
                     fmt::format("column {} fires before column {}: columns must fire in their order", c, c - 1));
  }
  return sensor;
}

ListedBeams flashBeams(double azimuth, double field, bool clockwise, std::uint32_t columns,
                       const std::vector<double>& elevation) {
  ListedBeams beams;
  for (const double up : elevation) {
    for (std::uint32_t c = 0; c < columns; ++c) {
      const double across =
          columns == 1 ? 0 : std::tan(field / 2) * (2.0 * c / (columns - 1) - 1) * (clockwise ? -1 : 1);
      beams.azimuth.push_back(azimuth + std::atan(across));
      beams.elevation.push_back(std::atan2(std::tan(up), std::hypot(1, across)));
      beams.time.push_back(0);
    }
  }
  return beams;
}

Rosette readRosette(const Value& value) {
  constexpr std::size_t kMostPrisms = 4;
  constexpr Range kTurns{-1e4, 1e4};
  constexpr Range kPhases{-360, 360};
  Fields f(value, "rosette");
  Rosette rosette;
  rosette.speed = f.numbers("turns_hz", kTurns);
  const std::size_t prisms = rosette.speed.size();
  if (prisms < 1 || prisms > kMostPrisms) {
    throw InputError(f.require("turns_hz").where, "turns_hz must be one to four frequencies, such as [121.6, -77.7]");
  }
  const auto perPrism = [&](const char* key, Range range) {
    std::vector<double> values = f.numbers(key, range);
    if (values.size() == prisms) return values;
    throw InputError(f.require(key).where,
                     fmt::format("{} must be {} numbers, one for each prism of turns_hz", key, prisms));
  };
  if (f.has("deflection_deg") == f.has("field_deg")) {
    throw InputError(value.where, "a rosette needs either field_deg or, for unequal prisms, deflection_deg");
  }
  rosette.angle =
      f.has("deflection_deg")
          ? perPrism("deflection_deg", {0, 85})
          : std::vector<double>(prisms, f.number("field_deg", {0.01, 170}) / 2 / static_cast<double>(prisms));
  rosette.phase = f.has("phase_deg") ? perPrism("phase_deg", kPhases) : std::vector<double>(prisms, 0);
  if (f.has("laser_azimuth_deg")) rosette.left = f.numbers("laser_azimuth_deg", {-60, 60});
  if (f.has("laser_elevation_deg")) rosette.up = f.numbers("laser_elevation_deg", {-60, 60});
  if (rosette.left.empty()) rosette.left.resize(rosette.up.size());
  if (rosette.up.empty()) rosette.up.resize(rosette.left.size());
  if (rosette.left.size() != rosette.up.size()) {
    throw InputError(value.where, fmt::format("laser_azimuth_deg has {} angles, but laser_elevation_deg has {}",
                                              rosette.left.size(), rosette.up.size()));
  }
  for (double& speed : rosette.speed) speed *= 2 * kPi;
  for (std::vector<double>* angles : {&rosette.angle, &rosette.phase, &rosette.left, &rosette.up}) {
    for (double& angle : *angles) angle = radians(angle);
  }
  if (const Value* mirror = f.find("mirror")) {
    Fields m(*mirror, "mirror");
    rosette.mirror = {radians(m.number("tilt_deg", {0, 90})), m.number("turns_hz", kTurns) * 2 * kPi,
                      radians(m.number("phase_deg", kPhases, 0))};
    m.finish();
  }
  f.finish();
  return rosette;
}

RasterScan readRasterScan(const Value& value) {
  Fields f(value, "raster");
  RasterScan raster;
  raster.zones = f.numbers("zones_deg", {-180, 180});
  if (raster.zones.empty()) {
    throw InputError(value.where, "zones_deg must be the azimuths of the zones' middles, such as [24, 0, -24]");
  }
  for (double& zone : raster.zones) zone = radians(zone);
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
  const std::uint32_t across = columns / raster.lines;
  const double line = period / raster.lines;
  const double step = raster.lineTime > 0 ? std::min(raster.lineTime, line) / (across - 1) : line / across;
  ListedBeams beams;
  for (const double zone : raster.zones) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const std::uint32_t row = column / across;
      const std::uint32_t place = column % across;
      const double turned = raster.width * place / (across - 1);
      const bool back = raster.alternate && row % 2 == 1;
      beams.azimuth.push_back(zone + (raster.width / 2 - turned) * (back ? -1 : 1));
      beams.elevation.push_back(std::lerp(raster.top, raster.bottom, static_cast<double>(row) / (raster.lines - 1)));
      beams.time.push_back(row * line + place * step);
    }
  }
  return beams;
}

}  // namespace scanmill
