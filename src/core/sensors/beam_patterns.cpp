#include "sensors/beam_patterns.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>

#include "base/file.h"
#include "config/text.h"
#include "sensors/text_table.h"

namespace scanmill {
namespace {

constexpr std::uint32_t kMostRings = 4096;
constexpr std::uint32_t kMostColumns = 65536;

// Finds the columns of a table of beams by their names.
class Columns {
 public:
  explicit Columns(const TextLine& head) : where_(head.where) {
    static const std::vector<std::string> kKnown{"azimuth_deg", "elevation_deg", "zenith_deg", "ring",
                                                 "column",      "origin_x_m",    "origin_y_m", "origin_z_m",
                                                 "time_s",      "time_ms",       "time_us",    "time_ns"};
    for (const std::string_view cell : cellsOf(head.text)) {
      const auto [stated, unit] = columnName(cell);
      const std::string name = unit.empty() ? stated : stated + "_" + unit;
      if (stated.starts_with("time") && std::find(kKnown.begin(), kKnown.end(), name) == kKnown.end()) {
        throw InputError(where_, fmt::format("the column {} states no unit that is known: name it time_s, time_ms, "
                                             "time_us or time_ns",
                                             quotedForMessage(cell)));
      }
      if (std::find(kKnown.begin(), kKnown.end(), name) == kKnown.end()) {
        throw InputError(where_,
                         fmt::format("the column {} is unknown{}", quotedForMessage(cell), suggestion(name, kKnown)));
      }
      if (!index_.emplace(name, index_.size()).second) {
        throw InputError(where_, fmt::format("the column {} is listed twice", name));
      }
      if (!stated.starts_with("time")) continue;
      if (!time_.empty()) {
        throw InputError(where_, fmt::format("the table has two columns of time: leave out {} or {}", time_, name));
      }
      time_ = name;
    }
    if (!has("azimuth_deg")) throw InputError(where_, "the table has no column azimuth_deg");
    if (!has("elevation_deg") && !has("zenith_deg")) {
      throw InputError(where_, "the table has no column elevation_deg (or zenith_deg)");
    }
    if (has("elevation_deg") && has("zenith_deg")) {
      throw InputError(where_, "the table has both elevation_deg and zenith_deg: leave out one of them");
    }
    if (has("ring") != has("column"))
      throw InputError(where_, "the table has only one of the columns ring and column: give both or none");
  }

  bool has(const std::string& name) const { return index_.contains(name); }
  std::size_t count() const { return index_.size(); }
  // Returns the time of a line (s), or 0 if the table has no times.
  double time(const std::vector<std::string_view>& cells, const Location& where) const {
    const double unit = time_ == "time_us" ? 1e-6 : time_ == "time_ns" ? 1e-9 : time_ == "time_ms" ? 1e-3 : 1;
    return number(time_, cells, where, {0, 100 / unit}) * unit;
  }
  double elevation(const std::vector<std::string_view>& cells, const Location& where) const {
    if (has("zenith_deg")) return radians(90 - number("zenith_deg", cells, where, {0, 180}));
    return radians(number("elevation_deg", cells, where, {-90, 90}));
  }
  double number(const std::string& name, const std::vector<std::string_view>& cells, const Location& where, Range range,
                double fallback = 0) const {
    const auto found = index_.find(name);
    if (found == index_.end()) return fallback;
    const double value = numberOf(cells[found->second], where);
    if (value >= range.low && value <= range.high) return value;
    throw InputError(where,
                     fmt::format("{} is {:g}, but must be from {:g} to {:g}", name, value, range.low, range.high));
  }

 private:
  Location where_;
  std::map<std::string, std::size_t> index_;
  std::string time_;  // the column of times; empty: none
};

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

}  // namespace

ListedSensor readListedBeams(const std::filesystem::path& file) {
  const std::string bytes = readFile(file);
  const std::vector<TextLine> lines = linesOf(bytes, file);
  const Columns columns(lines.front());
  const bool placed = columns.has("ring");
  std::vector<Row> rows;
  ListedSensor sensor{1, 0, {}};
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const Location& where = lines[i].where;
    const std::vector<std::string_view> cells = cellsOf(lines[i].text);
    if (cells.size() != columns.count()) {
      throw InputError(where, fmt::format("has {} cells, but the first line has {}", cells.size(), columns.count()));
    }
    const auto number = [&](const char* name, Range range) { return columns.number(name, cells, where, range); };
    Row row{radians(number("azimuth_deg", {-360, 360})),
            columns.elevation(cells, where),
            columns.time(cells, where),
            {static_cast<float>(number("origin_x_m", {-10, 10})), static_cast<float>(number("origin_y_m", {-10, 10})),
             static_cast<float>(number("origin_z_m", {-10, 10}))},
            countOf(number("ring", {0, kMostRings - 1}), where),
            placed ? countOf(number("column", {0, kMostColumns - 1}), where) : static_cast<std::uint32_t>(i - 1),
            where};
    sensor.rings = std::max(sensor.rings, row.ring + 1);
    sensor.columns = std::max(sensor.columns, row.column + 1);
    rows.push_back(row);
  }
  const std::size_t beams = std::size_t{sensor.rings} * sensor.columns;
  if (rows.empty() || rows.size() != beams || sensor.columns > kMostColumns) {
    throw InputError({file.string()},
                     fmt::format("has {} beams, but {} rings of {} columns (at most {}) need one line for each beam: a "
                                 "file with the beams of several revolutions must be cut to those of one",
                                 rows.size(), sensor.rings, sensor.columns, kMostColumns));
  }
  ListedBeams& all = sensor.beams;
  all.azimuth.resize(beams);
  all.elevation.resize(beams);
  all.time.resize(beams);
  all.origin.resize(beams);
  std::vector<bool> known(beams);
  for (const Row& row : rows) {
    const std::size_t beam = std::size_t{row.ring} * sensor.columns + row.column;
    if (known[beam]) {
      throw InputError(row.where, fmt::format("has ring {}, column {} of an earlier line: give each beam one line",
                                              row.ring, row.column));
    }
    known[beam] = true;
    all.azimuth[beam] = row.azimuth;
    all.elevation[beam] = row.elevation;
    all.time[beam] = row.time;
    all.origin[beam] = row.origin;
  }
  if (std::all_of(all.origin.begin(), all.origin.end(), [](const Vec3f& o) { return o == Vec3f{}; }))
    all.origin.clear();
  const std::vector<double> starts = all.columnStarts(sensor.columns);
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
  f.also({"field_deg", "deflection_deg", "turns_hz", "phase_deg", "laser_azimuth_deg", "laser_elevation_deg", "mirror"})
      .finish();
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
    m.also({"tilt_deg", "turns_hz", "phase_deg"}).finish();
    rosette.mirror = {radians(m.number("tilt_deg", {0, 90})), m.number("turns_hz", kTurns) * 2 * kPi,
                      radians(m.number("phase_deg", kPhases, 0))};
  }
  return rosette;
}

Raster readRaster(const Value& value) {
  Fields f(value, "raster");
  f.also({"zones_deg", "width_deg", "top_deg", "bottom_deg", "lines", "line_us", "alternate"}).finish();
  Raster raster;
  raster.zones = f.numbers("zones_deg", {-180, 180});
  if (raster.zones.empty()) {
    throw InputError(value.where, "zones_deg must be the azimuths of the zones' middles, such as [24, 0, -24]");
  }
  for (double& zone : raster.zones) zone = radians(zone);
  raster.width = radians(f.number("width_deg", {0.01, 180}));
  raster.top = radians(f.number("top_deg", {-90, 90}));
  raster.bottom = radians(f.number("bottom_deg", {-90, 90}));
  if (raster.top <= raster.bottom) throw InputError(value.where, "raster: top_deg must be above bottom_deg");
  raster.lines = static_cast<std::uint32_t>(f.integer("lines", 2, kMostColumns / 2));
  raster.lineTime = f.number("line_us", {0, 1e8}, 0) * 1e-6;
  raster.alternate = f.boolean("alternate", false);
  return raster;
}

ListedBeams rasterBeams(const Raster& raster, std::uint32_t columns, double period) {
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
