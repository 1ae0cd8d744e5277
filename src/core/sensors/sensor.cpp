#include "sensors/sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "config/fields.h"
#include "config/file_kind.h"
#include "sensors/beam_patterns.h"
#include "sensors/calibration.h"

namespace scanmill {

namespace {

constexpr double kMaxRings = 4096;
constexpr double kMaxColumns = 65536;

// Reads a count as a double, so that a value such as 1e12 can be refused with a message about the number of beams.
double readCount(const Value& value, std::string_view what) {
  const double count = readNumber(value, what);
  if (count != std::floor(count)) {
    throw InputError(value.where, fmt::format("{} must be a whole number, not {}", what, value.text));
  }
  return count;
}

// Returns the elevation of each ring (deg), in ring order.
std::vector<double> uniformElevations(const Value& value, std::uint32_t rings, const std::string& order,
                                      const Location& orderWhere) {
  Fields fields(value, "elevation_deg");
  const double top = fields.number("top", {-90, 90});
  const double bottom = fields.number("bottom", {-90, 90});
  fields.require("rings");
  fields.finish();
  if (top < bottom || (top == bottom && rings > 1)) {
    throw InputError(value.where, fmt::format("elevation_deg: top ({}) must be above bottom ({})", top, bottom));
  }
  if (order == "unordered") {
    throw InputError(
        orderWhere,
        "elevations by {top:, bottom:, rings:} are sorted, so that ring_order must be top_down or bottom_up");
  }
  std::vector<double> elevation(rings, (top + bottom) / 2);
  for (std::uint32_t ring = 0; ring < rings && rings > 1; ++ring) {
    const std::uint32_t fromTop = order == "top_down" ? ring : rings - 1 - ring;
    const double part = static_cast<double>(fromTop) / (rings - 1);
    elevation[ring] = top * (1 - part) + bottom * part;
  }
  return elevation;
}

std::vector<double> listedElevations(const Value& value, const std::string& order) {
  std::vector<double> elevation = readNumbers(value, "elevation_deg", {-90, 90});
  for (std::size_t ring = 1; ring < elevation.size() && order != "unordered"; ++ring) {
    const bool above = elevation[ring] > elevation[ring - 1];
    const bool below = elevation[ring] < elevation[ring - 1];
    if (order == "top_down" ? above : below) {
      throw InputError(
          value.items[ring].where,
          fmt::format("ring {} at {} deg is {} ring {} at {} deg, which contradicts `ring_order: {}`: sort the list, "
                      "or give `ring_order: unordered`",
                      ring, elevation[ring], above ? "above" : "below", ring - 1, elevation[ring - 1], order));
    }
  }
  return elevation;
}

// Returns the azimuth offset of each ring (deg), from a list that is repeated over the rings.
std::vector<double> readAzimuthOffsets(const Value* value, std::uint32_t rings) {
  if (value == nullptr) return std::vector<double>(rings, 0.0);
  std::vector<double> pattern = readNumbers(*value, "azimuth_offset_deg", {-180, 180});
  if (pattern.empty() || rings % pattern.size() != 0) {
    throw InputError(value->where, fmt::format("azimuth_offset_deg has {} entries: give one per ring ({}), or a "
                                               "pattern whose length divides the number of rings",
                                               pattern.size(), rings));
  }
  const std::size_t period = pattern.size();
  pattern.resize(rings);
  for (std::size_t ring = period; ring < rings; ++ring) pattern[ring] = pattern[ring - period];
  return pattern;
}

// Returns the firing time of each ring (us).
std::vector<double> readFiringTimes(const Value* value, const BeamTable& table) {
  if (value == nullptr) return std::vector<double>(table.rings, 0.0);
  constexpr Range kMicroseconds{0, 1e8};
  std::vector<double> times;
  if (value->kind == Value::Kind::Sequence) {
    times = readNumbers(*value, "firing_time_us", kMicroseconds);
    if (times.size() != table.rings) {
      throw InputError(value->where, fmt::format("firing_time_us has {} entries for {} rings: give one per ring",
                                                 times.size(), table.rings));
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
        throw InputError({file.string()},
                         fmt::format("has the times of {} lasers for {} rings", times.size(), table.rings));
      }
    } else {
      const double step = fields.number("step_us", kMicroseconds);
      for (std::uint32_t ring = 0; ring < table.rings; ++ring) times.push_back(step * ring);
    }
  }
  const double last = *std::max_element(times.begin(), times.end());
  const double column = table.columnPeriod() * 1e6;
  if (last >= column) {
    throw InputError(value->where,
                     fmt::format("firing_time_us: the last ring fires {:.6g} us after the first, but a column lasts "
                                 "{:.6g} us (1 s / {:.6g} revolutions x {:.6g} of a revolution / {} columns)",
                                 last, column, 1 / table.period, table.field / (2 * kPi), table.columns));
  }
  return times;
}

// Returns the shift of the beams' origin in each ring (m), read as one value per ring or one value for all rings; empty
// if all are zero.
std::vector<double> readOrigins(Fields& fields, std::string_view key, std::uint32_t rings) {
  const Value* value = fields.find(key);
  if (value == nullptr) return {};
  std::vector<double> origins = value->kind == Value::Kind::Sequence
                                    ? readNumbers(*value, std::string(key), {-10, 10})
                                    : std::vector<double>(rings, fields.number(key, {-10, 10}));
  if (origins.size() != rings) {
    throw InputError(value->where,
                     fmt::format("{} has {} entries for {} rings: give one per ring", key, origins.size(), rings));
  }
  if (std::all_of(origins.begin(), origins.end(), [](double o) { return o == 0; })) origins.clear();
  return origins;
}

std::vector<double> scaled(std::vector<double> values, double factor) {
  for (double& value : values) value *= factor;
  return values;
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

// Reads the beam's widths across and up, as two values or one value for both, and multiplies them by `unit`. `most`:
// the largest value allowed.
std::array<double, 2> readWidths(Fields& fields, std::string_view key, double most, double unit) {
  const Value* value = fields.find(key);
  if (value == nullptr) return {};
  if (value->kind != Value::Kind::Sequence) {
    const double both = fields.number(key, {0, most}) * unit;
    return {both, both};
  }
  const std::vector<double> widths = readNumbers(*value, std::string(key), {0, most});
  if (widths.size() != 2) {
    throw InputError(value->where, fmt::format("{} must be one width, or the two widths [horizontal, vertical]", key));
  }
  return {widths[0] * unit, widths[1] * unit};
}

// Throws InputError if the number of a calibration's lasers differs from the number of the preset's rings.
void checkSameLasers(const Value& preset, const Value& own) {
  const Value* elevation = preset.find("elevation_deg");
  const Value* calibration = Fields(own, "sensor").find("calibration");
  if (elevation == nullptr || calibration == nullptr) return;
  const std::size_t lasers = withCalibration(own, &preset).find("elevation_deg")->items.size();
  const auto rings = static_cast<std::size_t>(sensorSize(preset).rings);
  if (lasers == rings) return;
  throw InputError(calibration->where,
                   fmt::format("{} is for a sensor with {} lasers, but the preset has {} rings: name the preset of "
                               "that sensor, or give the sensor's other keys here",
                               calibration->text, lasers, rings));
}

const std::initializer_list<std::string_view> kSensorKeys = {
    "model",           "source",          "columns",       "rate_hz",     "direction",      "first_azimuth_deg",
    "field_deg",       "calibration",     "pattern",       "rosette",     "raster",         "sweep_ms",
    "beams",           "elevation_deg",   "ring_order",    "range_m",     "firing_time_us", "azimuth_offset_deg",
    "origin_offset_m", "origin_height_m", "origin_left_m", "origin_up_m", "exit_width_mm",  "turns_while_firing",
    "divergence_mrad", "beam_shape",      "pulse_ns",      "effects"};

// Sets a full circle, and fills the per-ring arrays with zeros, for patterns whose rings are not on cones.
void clearCones(BeamTable& table) {
  table.field = 2 * kPi;
  table.elevation.assign(table.rings, 0);
  table.azimuthOffset.assign(table.rings, 0);
  table.firingOffset.assign(table.rings, 0);
}

void readListed(Fields& fields, BeamTable& table) {
  fields.refuse({"columns", "elevation_deg", "azimuth_offset_deg", "firing_time_us", "turns_while_firing", "field_deg",
                 "first_azimuth_deg", "direction", "ring_order", "origin_offset_m", "origin_height_m", "origin_left_m",
                 "origin_up_m", "pattern", "rosette", "raster", "sweep_ms", "calibration"},
                "has no effect beside `beams`: leave it out");
  clearCones(table);
  const Value& where = fields.require("beams");
  const std::filesystem::path file = fields.path("beams");
  auto listed = std::make_shared<const ListedBeams>(readListedBeams(file).beams);
  const double last = *std::max_element(listed->time.begin(), listed->time.end());
  if (last >= table.period) {
    throw InputError(where.where,
                     fmt::format("the last beam of {} fires after {:.6g} s, but a revolution lasts {:.6g} s: "
                                 "lower rate_hz",
                                 file.string(), last, table.period));
  }
  for (std::uint32_t ring = 0; ring < table.rings; ++ring) {
    double sum = 0;
    for (std::uint32_t c = 0; c < table.columns; ++c) sum += listed->elevation[std::size_t{ring} * table.columns + c];
    table.elevation[ring] = sum / table.columns;
  }
  table.topDown = table.elevation.front() > table.elevation.back();
  table.pattern = std::move(listed);
}

// Refuses the keys of cones beside `rosette` or `raster`.
void refuseKeysOfCones(Fields& fields, const char* key, const char* otherKey) {
  fields.refuse({"elevation_deg", "azimuth_offset_deg", "turns_while_firing", "field_deg", "sweep_ms",
                 "first_azimuth_deg", "direction", "ring_order", "origin_offset_m", "origin_height_m", "origin_left_m",
                 "origin_up_m", "pattern", "calibration", otherKey},
                fmt::format("has no effect beside `{}`: leave it out", key));
}

void readRosetteBeams(Fields& fields, BeamTable& table) {
  refuseKeysOfCones(fields, "rosette", "raster");
  clearCones(table);
  table.pattern = readRosette(fields.require("rosette"));
  table.firingOffset = scaled(readFiringTimes(fields.find("firing_time_us"), table), 1e-6);
}

void readRasterBeams(Fields& fields, BeamTable& table) {
  refuseKeysOfCones(fields, "raster", "firing_time_us");
  clearCones(table);
  const RasterScan raster = readRasterScan(fields.require("raster"));
  if (table.columns % raster.lines != 0 || table.columns == raster.lines) {
    throw InputError(fields.require("columns").where,
                     fmt::format("columns must be a multiple of the {} lines of the raster, such as {}", raster.lines,
                                 raster.lines * std::max(2u, table.columns / raster.lines)));
  }
  table.pattern = std::make_shared<const ListedBeams>(rasterBeams(raster, table.columns, table.period));
  table.topDown = true;
}

void readCones(Fields& fields, const Value& value, BeamTable& table) {
  fields.require("columns");
  table.clockwise = fields.choice("direction", {"clockwise", "counterclockwise"}, "counterclockwise") == "clockwise";
  table.firstAzimuth = radians(fields.number("first_azimuth_deg", {-360, 360}, 0));
  const double field = fields.number("field_deg", {0, 360}, 360);
  if (field <= 0) throw InputError(fields.find("field_deg")->where, "field_deg must be above 0");
  table.field = field < 360 ? radians(field) : 2 * kPi;
  if (const Value* sweep = fields.find("sweep_ms")) {
    if (field >= 360) throw InputError(sweep->where, "sweep_ms has no effect in a full circle: leave it out");
    table.sweep = fields.number("sweep_ms", {1e-3, table.period * 1e3}) * 1e-3;
  }

  const std::string order = fields.choice("ring_order", {"top_down", "bottom_up", "unordered"}, "top_down");
  const Value* orderValue = fields.find("ring_order");
  const Value& elevationValue = fields.require("elevation_deg");
  const std::vector<double> elevation =
      elevationValue.kind == Value::Kind::Sequence
          ? listedElevations(elevationValue, order)
          : uniformElevations(elevationValue, table.rings, order, orderValue ? orderValue->where : value.where);
  table.elevation = scaled(elevation, radians(1));
  const double highest = *std::max_element(elevation.begin(), elevation.end());
  table.topDown = order == "top_down" || (order == "unordered" && elevation.front() == highest);
  table.azimuthOffset = scaled(readAzimuthOffsets(fields.find("azimuth_offset_deg"), table.rings), radians(1));
  table.firingOffset = scaled(readFiringTimes(fields.find("firing_time_us"), table), 1e-6);
  if (fields.boolean("turns_while_firing", false)) {
    // The angular velocity of the head (rad/s).
    const double speed = table.sweep > 0 ? table.field / table.sweep : 2 * kPi / table.period;
    const double turn = table.clockwise ? -speed : speed;
    for (std::uint32_t ring = 0; ring < table.rings; ++ring) {
      table.azimuthOffset[ring] += turn * table.firingOffset[ring];
    }
  }
  table.originOffset = fields.number("origin_offset_m", {0, 10}, 0);
  table.originHeight = fields.number("origin_height_m", {-10, 10}, 0);
  table.originLeft = readOrigins(fields, "origin_left_m", table.rings);
  table.originUp = readOrigins(fields, "origin_up_m", table.rings);
}

// Replaces the rings on cones by the pixels of a flash sensor.
void makeFlash(Fields& fields, BeamTable& table) {
  fields.refuse({"azimuth_offset_deg", "firing_time_us", "sweep_ms", "turns_while_firing", "origin_offset_m",
                 "origin_height_m", "origin_left_m", "origin_up_m"},
                "has no effect beside `pattern: flash`: leave it out");
  constexpr double kWidest = 170;  // deg, largest field of view of a flash sensor
  const Value& field = fields.require("field_deg");
  if (degrees(table.field) > kWidest) {
    throw InputError(field.where, fmt::format("field_deg of a flash sensor must be at most {}", kWidest));
  }
  const double middle = table.firstAzimuth + (table.clockwise ? -1 : 1) * table.field / 2;
  table.pattern = std::make_shared<const ListedBeams>(
      flashBeams(middle, table.field, table.clockwise, table.columns, table.elevation));
  table.field = 2 * kPi;
}

}  // namespace

Value resolveSensor(const Value& value) {
  Fields fields(value, "sensor");
  fields.also({"name", "preset", "mount"}).also(kSensorKeys).finish();
  Value merged;
  merged.kind = Value::Kind::Map;
  merged.where = value.where;
  if (fields.has("preset")) {
    const Value file = readYaml(fields.resource("preset", "pipelines/sensors"));
    if (file.kind == Value::Kind::Null) throw InputError(file.where, "the sensor preset is empty");
    expectKind(file, FileKind::Sensor);
    Fields(file, "sensor preset").also(kSensorKeys).finish();
    merged.entries = withCalibration(file).entries;
  }
  checkSameLasers(merged, value);
  for (const auto& entry : withCalibration(value, &merged).entries) {
    if (entry.key == "name" || entry.key == "preset" || entry.key == "mount") continue;
    const auto old = std::find_if(merged.entries.begin(), merged.entries.end(),
                                  [&](const auto& other) { return other.key == entry.key; });
    if (old != merged.entries.end()) {
      const bool fromCalibration = entry.key == "source" && value.find("source") == nullptr;
      const std::string sourceOfPreset = fromCalibration ? old->value.text + "; " : "";
      old->value = entry.value;
      old->value.text = sourceOfPreset + old->value.text;
    } else {
      merged.entries.push_back(entry);
    }
  }
  return merged;
}

SensorSize sensorSize(const Value& description) {
  const Value value = withCalibration(description);
  Fields fields(value, "sensor");
  if (fields.has("beams")) {
    const ListedSensor listed = readListedBeams(fields.path("beams"));
    return {listed.rings, listed.columns};
  }
  const Value& columnValue = fields.require("columns");
  const double columns = readCount(columnValue, "columns");
  const bool rosette = fields.has("rosette");
  const bool cones = fields.has("elevation_deg") || !(rosette || fields.has("raster"));
  const Value* ringValue = &fields.require(cones ? "elevation_deg" : rosette ? "rosette" : "raster");
  double rings = 0;
  if (!cones) {
    rings = static_cast<double>(rosette ? readRosette(*ringValue).lasers() : readRasterScan(*ringValue).zones.size());
  } else if (ringValue->kind == Value::Kind::Sequence) {
    rings = static_cast<double>(ringValue->items.size());
  } else if (ringValue->kind == Value::Kind::Map) {
    ringValue = &Fields(*ringValue, "elevation_deg").require("rings");
    rings = readCount(*ringValue, "rings");
  } else {
    throw InputError(ringValue->where,
                     "elevation_deg must be a list of angles, one per ring, or {top: 15, bottom: -15, rings: 16}");
  }
  const bool ringsFit = rings >= 1 && rings <= kMaxRings;
  if (!ringsFit || columns < 1 || columns > kMaxColumns) {
    throw InputError(ringsFit ? columnValue.where : ringValue->where,
                     fmt::format("rings x columns = {:.15g} x {:.15g} = {:.15g} beams per revolution, but a sensor has "
                                 "1 to {} rings and 1 to {} columns",
                                 rings, columns, rings * columns, kMaxRings, kMaxColumns));
  }
  return {static_cast<std::uint64_t>(rings), static_cast<std::uint64_t>(columns)};
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
  table->period = 1 / fields.number("rate_hz", {0.01, 1000});
  const std::string pattern = fields.choice("pattern", {"spinning", "flash"}, "spinning");
  if (fields.has("beams")) {
    readListed(fields, *table);
  } else if (fields.has("rosette")) {
    readRosetteBeams(fields, *table);
  } else if (fields.has("raster")) {
    readRasterBeams(fields, *table);
  } else {
    readCones(fields, value, *table);
    if (pattern == "flash") makeFlash(fields, *table);
  }
  readRange(fields, *table);
  table->divergence = readWidths(fields, "divergence_mrad", 200, 1e-3);
  table->exitWidth = readWidths(fields, "exit_width_mm", 1000, 1e-3);
  table->uniformBeam = fields.choice("beam_shape", {"gaussian", "uniform"}, "gaussian") == "uniform";
  table->pulse = fields.number("pulse_ns", {0, 1e4}, 0) * 1e-9;
  fields.also({"columns", "calibration", "effects"}).finish();

  fillBeams(*table);
  return table;
}

}  // namespace scanmill
