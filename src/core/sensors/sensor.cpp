#include "sensors/sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "config/fields.h"
#include "config/resources.h"
#include "sensors/beam_patterns.h"
#include "sensors/calibration.h"

namespace scanmill {

namespace {

// Reads a count as a double, so that a value such as 1e12 can be refused with a message about the number of beams.
double readCount(const Value& value, std::string_view key) {
  const double count = readNumber(value, key);
  if (count != std::floor(count)) throw InputError(value.where, "{} must be a whole number, not {}", key, value.text);
  return count;
}

// Reads {top:, bottom:, rings:} and returns the elevations (deg) of the evenly spaced rings. `order`: value of the key
// ring_order, top_down or bottom_up; `orderWhere`: location of the key in the file.
std::vector<double> uniformElevations(const Value& value, std::uint32_t rings, const std::string& order,
                                      const Location& orderWhere) {
  Fields fields(value, "elevation_deg");
  const double top = fields.number("top", {-90, 90});
  const double bottom = fields.number("bottom", {-90, 90});
  fields.require("rings");
  fields.finish();
  if (top < bottom || (top == bottom && rings > 1)) {
    throw InputError(value.where, "elevation_deg: top ({}) must be above bottom ({})", top, bottom);
  }
  if (order == "unordered") {
    throw InputError(
        orderWhere,
        "elevations by {top:, bottom:, rings:} are sorted, so that ring_order must be top_down or bottom_up");
  }
  std::vector<double> elevation(rings, (top + bottom) / 2);
  for (std::uint32_t ring = 0; ring < rings && rings > 1; ++ring) {
    const std::uint32_t fromTop = order == "top_down" ? ring : rings - 1 - ring;
    const double fraction = static_cast<double>(fromTop) / (rings - 1);
    elevation[ring] = top * (1 - fraction) + bottom * fraction;
  }
  return elevation;
}

// Reads each ring's elevation (deg) from a list. Throws InputError if the list is not in `order` (the key ring_order).
std::vector<double> listedElevations(const Value& value, const std::string& order) {
  std::vector<double> elevation = readNumbers(value, "elevation_deg", {-90, 90});
  for (std::size_t ring = 1; ring < elevation.size() && order != "unordered"; ++ring) {
    const bool above = elevation[ring] > elevation[ring - 1];
    const bool below = elevation[ring] < elevation[ring - 1];
    if (order == "top_down" ? above : below) {
      throw InputError(value.items[ring].where,
                       "ring {} at {} deg is {} ring {} at {} deg, which contradicts `ring_order: {}`: sort the list, "
                       "or give `ring_order: unordered`",
                       ring, elevation[ring], above ? "above" : "below", ring - 1, elevation[ring - 1], order);
    }
  }
  return elevation;
}

// Returns each ring's azimuth offset (deg): the list `value`, repeated over the rings; zeros if `value` is null.
std::vector<double> readAzimuthOffsets(const Value* value, std::uint32_t rings) {
  if (value == nullptr) return std::vector<double>(rings, 0.0);
  const std::vector<double> pattern = readNumbers(*value, "azimuth_offset_deg", {-180, 180});
  if (pattern.empty() || rings % pattern.size() != 0) {
    throw InputError(value->where,
                     "azimuth_offset_deg has {} entries: give one per ring ({}), or a "
                     "pattern whose length divides the number of rings",
                     pattern.size(), rings);
  }
  std::vector<double> offsets(rings);
  for (std::size_t ring = 0; ring < rings; ++ring) offsets[ring] = pattern[ring % pattern.size()];
  return offsets;
}

// Returns the firing time of each ring (us after the start of its column), from a list, a table in a file or a constant
// step; zeros if `value` is null. Rings, columns, period, field and sweep of `table` must be set. Throws InputError if
// a ring would fire after the start of the next column.
std::vector<double> readFiringTimes(const Value* value, const BeamTable& table) {
  if (value == nullptr) return std::vector<double>(table.rings, 0.0);
  constexpr Range kMicroseconds{0, 1e8};
  std::vector<double> times;
  if (value->kind == Value::Kind::Sequence) {
    times = readNumbers(*value, "firing_time_us", kMicroseconds);
    if (times.size() != table.rings) {
      throw InputError(value->where, "firing_time_us has {} entries for {} rings: give one per ring", times.size(),
                       table.rings);
    }
  } else {
    Fields fields(*value, "firing_time_us");
    fields.also({"step_us", "file"}).finish();
    if (fields.has("file") && fields.has("step_us")) {
      throw InputError(fields.require("step_us").where,
                       "firing_time_us must have either a file or a step_us, not both");
    }
    if (fields.has("file")) {
      const std::filesystem::path file = fields.path("file");
      times = readFiringTable(file);
      if (times.size() != table.rings) {
        throw InputError({file.string()}, "has the times of {} lasers for {} rings", times.size(), table.rings);
      }
    } else {
      const double step = fields.number("step_us", kMicroseconds);
      for (std::uint32_t ring = 0; ring < table.rings; ++ring) times.push_back(step * ring);
    }
  }
  const double lastFiring = std::ranges::max(times);
  const double columnDuration = table.columnPeriod() * 1e6;  // us
  if (lastFiring >= columnDuration) {
    throw InputError(value->where,
                     "firing_time_us: the last ring fires {:.6g} us after the first, but a column lasts "
                     "{:.6g} us (1 s / {:.6g} revolutions x {:.6g} of a revolution / {} columns)",
                     lastFiring, columnDuration, 1 / table.period, table.field / (2 * kPi), table.columns);
  }
  return times;
}

// Returns the shift (m) of the beams' origin for each ring, from a key with one value per ring or one for all rings.
// Returns an empty list if the key is absent or all shifts are zero.
std::vector<double> readOrigins(Fields& fields, std::string_view key, std::uint32_t rings) {
  const Value* value = fields.find(key);
  if (value == nullptr) return {};
  std::vector<double> origins = value->kind == Value::Kind::Sequence
                                    ? readNumbers(*value, std::string(key), {-10, 10})
                                    : std::vector<double>(rings, fields.number(key, {-10, 10}));
  if (origins.size() != rings) {
    throw InputError(value->where, "{} has {} entries for {} rings: give one per ring", key, origins.size(), rings);
  }
  if (std::ranges::all_of(origins, [](double shift) { return shift == 0; })) origins.clear();
  return origins;
}

void readRange(Fields& fields, BeamTable& table) {
  const Value& value = fields.require("range_m");
  const std::vector<double> limits = readNumbers(value, "range_m", {0, 1e6});
  if (limits.size() != 2 || limits[0] >= limits[1]) {
    throw InputError(value.where, "range_m must be [nearest, farthest] in metres, the nearest below the farthest");
  }
  table.minRange = limits[0];
  table.maxRange = limits[1];
}

// Returns a beam's horizontal and vertical width (rad or m), from a key with two values or one value for both, each
// from 0 to `largest` in mrad or mm. Returns zeros if the key is absent.
std::array<double, 2> readWidths(Fields& fields, std::string_view key, double largest) {
  const Value* value = fields.find(key);
  if (value == nullptr) return {};
  if (value->kind != Value::Kind::Sequence) {
    const double width = fields.number(key, {0, largest}) * 1e-3;
    return {width, width};
  }
  const std::vector<double> widths = readNumbers(*value, std::string(key), {0, largest});
  if (widths.size() != 2) {
    throw InputError(value->where, "{} must be one width, or the two widths [horizontal, vertical]", key);
  }
  return {widths[0] * 1e-3, widths[1] * 1e-3};
}

// Throws InputError if the calibration that `sensor` names has more or fewer lasers than the preset has rings. A sensor
// without calibration and a preset without rings on cones are not checked.
void checkSameLasers(const Value& preset, const Value& sensor) {
  const Value* elevation = preset.find("elevation_deg");
  const Value* calibration = Fields(sensor, "sensor").find("calibration");
  if (elevation == nullptr || calibration == nullptr) return;
  const std::size_t lasers = withCalibration(sensor, &preset).find("elevation_deg")->items.size();
  const auto rings = static_cast<std::size_t>(sensorSize(preset).rings);
  if (lasers == rings) return;
  throw InputError(calibration->where,
                   "{} is for a sensor with {} lasers, but the preset has {} rings: name the preset of "
                   "that sensor, or give the sensor's other keys here",
                   calibration->text, lasers, rings);
}

const std::initializer_list<std::string_view> kSensorKeys = {"model",           "source",
                                                             "columns",         "rate_hz",
                                                             "direction",       "first_azimuth_deg",
                                                             "field_deg",       "calibration",
                                                             "pattern",         "rosette",
                                                             "raster",          "sweep_ms",
                                                             "lines",           "sectors",
                                                             "beams",           "elevation_deg",
                                                             "ring_order",      "range_m",
                                                             "firing_time_us",  "azimuth_offset_deg",
                                                             "origin_offset_m", "origin_height_m",
                                                             "origin_left_m",   "origin_up_m",
                                                             "exit_width_mm",   "turns_while_firing",
                                                             "divergence_mrad", "beam_shape",
                                                             "pulse_ns",        "effects",
                                                             "intensity_from"};

// Throws InputError if the sensor has one of `otherKeys` or a key of rings on cones, which have no effect beside `key`.
void refuseBeside(Fields& fields, const char* key, std::initializer_list<std::string_view> otherKeys) {
  const std::string why = fmt::format("has no effect beside `{}`: leave it out", key);
  fields.refuse(otherKeys, why);
  fields.refuse({"elevation_deg", "azimuth_offset_deg", "turns_while_firing", "field_deg", "sweep_ms",
                 "first_azimuth_deg", "direction", "ring_order", "origin_offset_m", "origin_height_m", "origin_left_m",
                 "origin_up_m", "pattern", "calibration", "sectors"},
                why);
}

// Sets the members that describe cones (a full circle, zeros for each ring) for patterns whose rings are not on cones.
void clearCones(BeamTable& table) {
  table.field = 2 * kPi;
  table.elevation.assign(table.rings, 0);
  table.azimuthOffset.assign(table.rings, 0);
  table.firingOffset.assign(table.rings, 0);
}

// Each of the next five functions reads one kind of beams into a table that has its rings, columns and period, and
// throws InputError for keys of the other kinds. readListed() reads the file that the key `beams` names: one line per
// beam.
void readListed(Fields& fields, BeamTable& table) {
  refuseBeside(fields, "beams", {"columns", "firing_time_us", "rosette", "raster", "lines"});
  clearCones(table);
  const Value& where = fields.require("beams");
  const std::filesystem::path file = fields.path("beams");
  auto listed = std::make_shared<const ListedBeams>(readListedBeams(file).beams);
  const double lastFiring = std::ranges::max(listed->time);  // s since the start of the revolution
  if (lastFiring >= table.period) {
    throw InputError(where.where,
                     "the last beam of {} fires after {:.6g} s, but a revolution lasts {:.6g} s: lower rate_hz",
                     file.string(), lastFiring, table.period);
  }
  for (std::uint32_t ring = 0; ring < table.rings; ++ring) {
    const auto firstOfRing = listed->elevation.begin() + std::ptrdiff_t{ring} * table.columns;
    table.elevation[ring] = std::accumulate(firstOfRing, firstOfRing + table.columns, 0.0) / table.columns;
  }
  table.topDown = table.elevation.front() > table.elevation.back();
  table.pattern = std::move(listed);
}

void readRosetteBeams(Fields& fields, BeamTable& table) {
  refuseBeside(fields, "rosette", {"raster", "lines"});
  clearCones(table);
  table.pattern = readRosette(fields.require("rosette"));
  table.firingOffset = scaledBy(1e-6, readFiringTimes(fields.find("firing_time_us"), table));
}

void readRasterBeams(Fields& fields, BeamTable& table) {
  refuseBeside(fields, "raster", {"firing_time_us", "lines"});
  clearCones(table);
  const RasterScan raster = readRasterScan(fields.require("raster"));
  if (table.columns % raster.lines != 0 || table.columns == raster.lines) {
    throw InputError(fields.require("columns").where,
                     "columns must be a multiple of the {} lines of the raster, such as {}", raster.lines,
                     raster.lines * std::max(2u, table.columns / raster.lines));
  }
  table.pattern = std::make_shared<const ListedBeams>(rasterBeams(raster, table.columns, table.period));
  table.topDown = true;
}

void readLineBeams(Fields& fields, BeamTable& table) {
  refuseBeside(fields, "lines", {"firing_time_us"});
  clearCones(table);
  const LineScan lines = readLineScan(fields.require("lines"), table.period);
  table.pattern = std::make_shared<const ListedBeams>(lineBeams(lines, table.columns, table.period));
}

// Reads rings that scan cones about the sensor's axis into `table`. `description`: the map that `fields` reads.
void readCones(Fields& fields, const Value& description, BeamTable& table) {
  fields.require("columns");
  table.clockwise = fields.choice("direction", {"clockwise", "counterclockwise"}, "counterclockwise") == "clockwise";
  table.firstAzimuth = radians(fields.number("first_azimuth_deg", {-360, 360}, 0));
  const double fieldDegrees = fields.number("field_deg", {0, 360}, 360);
  if (fieldDegrees <= 0) throw InputError(fields.find("field_deg")->where, "field_deg must be above 0");
  table.field = fieldDegrees < 360 ? radians(fieldDegrees) : 2 * kPi;
  if (const Value* sweep = fields.find("sweep_ms")) {
    if (fieldDegrees >= 360) throw InputError(sweep->where, "sweep_ms has no effect in a full circle: leave it out");
    table.sweep = fields.number("sweep_ms", {1e-3, table.period * 1e3}) * 1e-3;
  }
  if (table.sectors > 1) {
    if (fieldDegrees < 360) fields.refuse({"sectors"}, "divides a full circle, but field_deg is less: leave it out");
    const std::uint32_t gaps = table.columns - 1;  // between the columns of a sector
    table.field = gaps * 2 * kPi / (static_cast<double>(table.columns) * table.sectors);
    table.sweep = gaps * table.period / table.columns;
  }

  const std::string order = fields.choice("ring_order", {"top_down", "bottom_up", "unordered"}, "top_down");
  const Value* orderValue = fields.find("ring_order");
  const Value& elevationValue = fields.require("elevation_deg");
  const std::vector<double> elevation =
      elevationValue.kind == Value::Kind::Sequence
          ? listedElevations(elevationValue, order)
          : uniformElevations(elevationValue, table.rings, order, orderValue ? orderValue->where : description.where);
  table.elevation = scaledBy(radians(1), elevation);
  table.topDown = order == "top_down" || (order == "unordered" && elevation.front() == std::ranges::max(elevation));
  table.azimuthOffset = scaledBy(radians(1), readAzimuthOffsets(fields.find("azimuth_offset_deg"), table.rings));
  table.firingOffset = scaledBy(1e-6, readFiringTimes(fields.find("firing_time_us"), table));
  if (fields.boolean("turns_while_firing", false)) {
    const double speed = table.sweep > 0 ? table.field / table.sweep : 2 * kPi / table.period;
    const double angularVelocity = table.clockwise ? -speed : speed;  // rad/s, of the head, counter-clockwise
    for (std::uint32_t ring = 0; ring < table.rings; ++ring) {
      table.azimuthOffset[ring] += angularVelocity * table.firingOffset[ring];
    }
  }
  table.originOffset = fields.number("origin_offset_m", {0, 10}, 0);
  table.originHeight = fields.number("origin_height_m", {-10, 10}, 0);
  table.originLeft = readOrigins(fields, "origin_left_m", table.rings);
  table.originUp = readOrigins(fields, "origin_up_m", table.rings);
}

// Replaces the rings on cones, which readCones() has read, by the pixels of a flash sensor.
void makeFlash(Fields& fields, BeamTable& table) {
  fields.refuse({"azimuth_offset_deg", "firing_time_us", "sweep_ms", "sectors", "turns_while_firing", "origin_offset_m",
                 "origin_height_m", "origin_left_m", "origin_up_m"},
                "has no effect beside `pattern: flash`: leave it out");
  constexpr double kWidest = 170;  // deg, largest field of view of a flash sensor
  const Value& field = fields.require("field_deg");
  if (degrees(table.field) > kWidest) {
    throw InputError(field.where, "field_deg of a flash sensor must be at most {}", kWidest);
  }
  const double middle = table.firstAzimuth + (table.clockwise ? -1 : 1) * table.field / 2;
  table.pattern = std::make_shared<const ListedBeams>(
      flashBeams(middle, table.field, table.clockwise, table.columns, table.elevation));
  table.field = 2 * kPi;
}

constexpr Range kRatesHz{1e-4, 1000};

// Returns into how many parts a turn is divided, each of which is a revolution of its own.
std::uint32_t readSectors(Fields& fields) {
  return static_cast<std::uint32_t>(fields.has("sectors") ? fields.integer("sectors", 1, 256) : 1);
}

struct RingCount {
  double rings = 0;  // not yet checked against kMostRings
  Location where;    // location of the value that gives the number
};

// Returns the number of rings of a sensor whose beams are not listed: from `elevation_deg` or, in its absence, the
// lasers of `rosette`, the zones of `raster`, or one for `lines`.
RingCount readRingCount(Fields& fields) {
  if (!fields.has("elevation_deg") && fields.has("lines")) return {1, fields.require("lines").where};
  if (!fields.has("elevation_deg") && fields.has("rosette")) {
    const Value& rosette = fields.require("rosette");
    return {static_cast<double>(readRosette(rosette).lasers()), rosette.where};
  }
  if (!fields.has("elevation_deg") && fields.has("raster")) {
    const Value& raster = fields.require("raster");
    return {static_cast<double>(readRasterScan(raster).zones.size()), raster.where};
  }
  const Value& elevation = fields.require("elevation_deg");
  if (elevation.kind == Value::Kind::Sequence) return {static_cast<double>(elevation.items.size()), elevation.where};
  if (elevation.kind == Value::Kind::Map) {
    const Value& rings = Fields(elevation, "elevation_deg").require("rings");
    return {readCount(rings, "rings"), rings.where};
  }
  throw InputError(elevation.where,
                   "elevation_deg must be a list of angles, one per ring, or {top: 15, bottom: -15, rings: 16}");
}

}  // namespace

Value resolveSensor(const Value& value) {
  Fields fields(value, "sensor");
  fields.also({"name", "preset", "mount"}).also(kSensorKeys).finish();
  Value merged = mapValue({}, value.where);
  if (fields.has("preset")) {
    const Value file = readYaml(fields.resource("preset", "pipelines/sensors"));
    if (file.kind == Value::Kind::Null) throw InputError(file.where, "the sensor preset is empty");
    expectKind(file, FileKind::Sensor);
    Fields(file, "sensor preset").also(kSensorKeys).finish();
    merged.entries = withCalibration(file).entries;
  }
  checkSameLasers(merged, value);
  if (fields.has("elevation_deg")) {  // these are other lasers than the preset's, whose origins do not fit them
    std::erase_if(merged.entries,
                  [](const Value::Entry& e) { return e.key == "origin_left_m" || e.key == "origin_up_m"; });
  }
  for (const auto& entry : withCalibration(value, &merged).entries) {
    if (entry.key == "name" || entry.key == "preset" || entry.key == "mount") continue;
    const auto inPreset = std::ranges::find(merged.entries, entry.key, &Value::Entry::key);
    if (inPreset == merged.entries.end()) {
      merged.entries.push_back(entry);
      continue;
    }
    // withCalibration() may have added the key `source`, which is then appended to the preset's `source`.
    const bool sourceIsAdded = entry.key == "source" && value.find("source") == nullptr;
    const std::string sourceOfPreset = sourceIsAdded ? inPreset->value.text + "; " : "";
    inPreset->value = entry.value;
    inPreset->value.text = sourceOfPreset + entry.value.text;
  }
  return merged;
}

SensorSize sensorSize(const Value& description) {
  const Value value = withCalibration(description);
  Fields fields(value, "sensor");
  const std::uint32_t sectors = readSectors(fields);
  const double period = 1 / fields.number("rate_hz", kRatesHz, 10) / sectors;
  if (fields.has("beams")) {
    const ListedSensor listed = readListedBeams(fields.path("beams"));
    return {listed.rings, listed.columns, period};
  }
  const Value& columnValue = fields.require("columns");
  const double columns = readCount(columnValue, "columns");
  const auto [rings, ringsWhere] = readRingCount(fields);
  const bool ringsFit = rings >= 1 && rings <= kMostRings;
  if (!ringsFit || columns < 1 || columns > kMostColumns) {
    throw InputError(ringsFit ? columnValue.where : ringsWhere,
                     "rings x columns = {:.15g} x {:.15g} = {:.15g} beams per revolution, but a sensor has "
                     "1 to {} rings and 1 to {} columns",
                     rings, columns, rings * columns, kMostRings, kMostColumns);
  }
  const auto wholeColumns = static_cast<std::uint64_t>(columns);
  if (sectors > 1 && (wholeColumns % sectors != 0 || wholeColumns < 2 * std::uint64_t{sectors})) {
    throw InputError(fields.require("sectors").where, "sectors must divide the {} columns into two or more for each",
                     columns);
  }
  return {static_cast<std::uint64_t>(rings), wholeColumns / sectors, period, sectors};
}

std::shared_ptr<const BeamTable> makeBeams(const Value& description) {
  const SensorSize size = sensorSize(description);
  const Value value = withCalibration(description);
  auto table = std::make_shared<BeamTable>();
  table->rings = static_cast<std::uint32_t>(size.rings);
  table->columns = static_cast<std::uint32_t>(size.columns);

  Fields fields(value, "sensor");
  table->model = fields.text("model", "custom");
  table->source = fields.text("source", "");
  fields.require("rate_hz");
  table->sectors = size.sectors;
  table->period = size.period;
  const std::string pattern = fields.choice("pattern", {"spinning", "flash"}, "spinning");
  if (fields.has("beams")) {
    readListed(fields, *table);
  } else if (fields.has("rosette")) {
    readRosetteBeams(fields, *table);
  } else if (fields.has("raster")) {
    readRasterBeams(fields, *table);
  } else if (fields.has("lines")) {
    readLineBeams(fields, *table);
  } else {
    readCones(fields, value, *table);
    if (pattern == "flash") makeFlash(fields, *table);
  }
  readRange(fields, *table);
  table->divergence = readWidths(fields, "divergence_mrad", 200);
  table->exitWidth = readWidths(fields, "exit_width_mm", 1000);
  table->uniformBeam = fields.choice("beam_shape", {"gaussian", "uniform"}, "gaussian") == "uniform";
  table->pulse = fields.number("pulse_ns", {0, 1e4}, 0) * 1e-9;
  fields.choice("intensity_from", {"scans", "estimate"}, "estimate");  // for `scanmill list sensors` alone
  fields.also({"columns", "calibration", "effects", "sectors"}).finish();

  fillBeams(*table);
  return table;
}

}  // namespace scanmill
