#include "sensors/calibration.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "base/file.h"
#include "base/format_support.h"
#include "base/hash.h"
#include "config/fields.h"
#include "config/text.h"

namespace scanmill {

namespace {

// The keys per ring that follow from a calibration and the values of the lasers that they get.
constexpr std::pair<const char*, double Laser::*> kRingKeys[] = {{"elevation_deg", &Laser::elevation},
                                                                 {"azimuth_offset_deg", &Laser::azimuth},
                                                                 {"origin_left_m", &Laser::left},
                                                                 {"origin_up_m", &Laser::up}};

// Reads a file of Velodyne's ROS drivers and returns its lasers from top to bottom.
std::vector<Laser> readVelodyneLasers(const Value& file) {
  const Value* items = file.find("lasers");
  if (file.kind != Value::Kind::Map || items == nullptr || items->kind != Value::Kind::Sequence ||
      items->items.empty()) {
    throw InputError(file.where,
                     "is not a calibration: it must be a map with a list `lasers`, as in the ROS drivers of Velodyne "
                     "sensors; Ouster's metadata need the suffix .json, tables of beams .csv");
  }
  LeftOut leftOut;
  for (const Value::Entry& entry : file.entries) leftOut.addKeyword(velodyneFormat(), entry.key);
  std::vector<Laser> lasers;
  for (const Value& item : items->items) {
    Fields laser(item, "laser");
    for (const Value::Entry& entry : item.entries) {
      laser.also({entry.key});
      leftOut.addKeyword(velodyneFormat(), entry.key);
    }
    const auto angleDegrees = [&](const char* key, double limit) {
      return degrees(readNumber(laser.require(key), fmt::format("laser: {} (rad)", key), {-limit, limit}));
    };
    const auto offset = [&](const char* key) {
      constexpr double kLimit = 0.5;  // m; the largest offset of a Velodyne sensor is 0.22 m
      const Value* const value = laser.find(key);
      return value == nullptr ? 0 : readNumber(*value, fmt::format("laser: {} (m)", key), {-kLimit, kLimit});
    };
    lasers.push_back({.elevation = angleDegrees("vert_correction", kPi / 2),
                      .azimuth = angleDegrees("rot_correction", kPi),
                      .left = offset("horiz_offset_correction"),
                      .up = offset("vert_offset_correction")});
  }
  leftOut.warn(file.where.file);
  std::ranges::stable_sort(lasers, std::greater(), &Laser::elevation);
  return lasers;
}

Value scalar(const std::string& text, const Location& where) {
  Value value;
  value.kind = Value::Kind::Scalar;
  value.where = where;
  value.text = text;
  return value;
}

// Adds an entry to a map, or replaces the entry with the same key.
void setEntry(Value::Entry entry, Value& map) {
  std::erase_if(map.entries, [&](const Value::Entry& e) { return e.key == entry.key; });
  map.entries.push_back(std::move(entry));
}

// Returns a list of one value of each laser, in the lasers' order.
Value listOf(const std::vector<Laser>& lasers, double Laser::*member, const Location& where) {
  Value list;
  list.kind = Value::Kind::Sequence;
  list.where = where;
  for (const Laser& laser : lasers) list.items.push_back(scalar(fmt::format("{}", laser.*member), where));
  return list;
}

// Adds the calibration file's name and hash to the sensor's key `source`, so that the manifest identifies the sensor
// unit.
void addToSource(Value& sensor, const Location& file) {
  const std::string calibration =
      fmt::format("calibration {} (SHA-256 {})", std::filesystem::path(file.file).filename().string(),
                  sha256(readFile(file.file)).substr(0, 16));
  const auto source = std::ranges::find(sensor.entries, "source", &Value::Entry::key);
  if (source != sensor.entries.end() && source->value.kind != Value::Kind::Null) {
    source->value.text += "; " + calibration;
    return;
  }
  Value text = scalar(calibration, file);
  text.quoted = true;
  setEntry({"source", std::move(text)}, sensor);
}

// Returns the value of the key `ring_order` that describes the order of these lasers.
const char* orderOf(const std::vector<Laser>& lasers) {
  if (std::ranges::is_sorted(lasers, std::greater(), &Laser::elevation)) return "top_down";
  return std::ranges::is_sorted(lasers, std::less(), &Laser::elevation) ? "bottom_up" : "unordered";
}

// The contents of a calibration file.
struct Unit {
  std::vector<Laser> lasers;
  std::vector<Value::Entry> furtherKeys;  // the same keys in the sensor file replace them
};

// Reads Ouster's metadata. Takes only the columns that the sensor sends according to the file or, if `value` states
// columns or a field, all columns of the revolution. Throws InputError if the file lacks the columns or the rate, and
// neither `value` nor `preset` (null: none) has them.
Unit readOusterUnit(const std::filesystem::path& file, const Value& value, const Value* preset) {
  const Fields fields(value, "sensor");
  const OusterMetadata m = readOusterMetadata(file);
  const auto isGiven = [&](const char* key) {
    return fields.has(key) || (preset != nullptr && Fields(*preset, "preset").has(key));
  };
  if ((m.columns == 0 && !isGiven("columns")) || (m.rate == 0 && !isGiven("rate_hz"))) {
    throw InputError({file.string()},
                     "has no lidar_mode, which states the columns and the rate: give `columns` and `rate_hz` beside "
                     "`calibration`");
  }
  Unit unit;
  for (std::size_t i = 0; i < m.elevation.size(); ++i) {
    unit.lasers.push_back({.elevation = m.elevation[i], .azimuth = m.azimuth[i]});
  }
  const Location where{file.string()};
  const auto addKey = [&](const char* key, const std::string& text) {
    unit.furtherKeys.push_back({key, scalar(text, where)});
  };
  const bool onlyWindow = !fields.has("columns") && !fields.has("field_deg");
  const std::uint32_t columns = onlyWindow ? m.windowColumns : m.columns;
  const std::uint32_t firstColumn = onlyWindow ? m.firstColumn : 0;
  const double columnStep = m.columns == 0 ? 0 : 360.0 / m.columns;  // deg, clockwise
  if (!m.model.empty()) addKey("model", m.model);
  if (columns > 0) addKey("columns", std::to_string(columns));
  if (m.rate > 0) addKey("rate_hz", fmt::format("{}", m.rate));
  addKey("direction", "clockwise");
  addKey("first_azimuth_deg", fmt::format("{}", std::remainder(m.firstAzimuth - columnStep * firstColumn, 360.0)));
  addKey("origin_offset_m", fmt::format("{}", m.originOffset));
  addKey("origin_height_m", fmt::format("{}", m.originHeight));
  if (columns < m.columns) addKey("field_deg", fmt::format("{}", columnStep * (columns - 1)));
  return unit;
}

// Reads a calibration file, whose format follows from its suffix. `value`, `preset`: as for withCalibration().
Unit readUnit(const std::filesystem::path& file, const Value& value, const Value* preset) {
  const std::string suffix = lowerExtension(file);
  if (suffix == ".json") return readOusterUnit(file, value, preset);
  if (suffix == ".csv") return {readBeamTable(file), {}};
  if (suffix == ".dat") {
    throw InputError({file.string()},
                     "is a correction file of a Hesai sensor with mirrors, whose beams do not lie on cones: such files "
                     "are not read");
  }
  if (suffix == ".xml") {
    throw InputError({file.string()},
                     "is a calibration of VeloView, in degrees and centimetres: convert it with gen_calibration.py of "
                     "velodyne_pointcloud, which writes the .yaml that is read");
  }
  return {readVelodyneLasers(readYaml(file)), {}};
}

bool hasFiring(const Unit& unit) {
  return std::ranges::any_of(unit.lasers, [](const Laser& laser) { return laser.firing != 0; });
}

// Throws InputError if the firing times come from the preset, but the file lists its lasers in the reverse order of the
// preset's rings. `sensor`: the map that overrides the preset.
void checkFiring(const Value& preset, const Value& sensor, const Unit& unit, const Location& where) {
  if (preset.find("firing_time_us") == nullptr || sensor.find("firing_time_us") != nullptr || hasFiring(unit)) return;
  const Value* const order = preset.find("ring_order");
  const std::string presetOrder = order == nullptr ? "top_down" : order->text;
  const std::string fileOrder = orderOf(unit.lasers);
  if (presetOrder == fileOrder || presetOrder == "unordered" || fileOrder == "unordered") return;
  throw InputError(where, fmt::format("the firing times of the preset are for rings in the order {}, but the file "
                                      "lists its lasers {}: reverse the lines of the file, or give firing_time_us",
                                      presetOrder, fileOrder));
}

}  // namespace

const FormatSupport& velodyneFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "Velodyne calibration",
      ".yaml",
      {{Read, "lasers num_lasers laser_id vert_correction rot_correction vert_offset_correction"},
       {Read, "horiz_offset_correction"},
       {Unused, "dist_correction dist_correction_x dist_correction_y two_pt_correction_available distance_resolution"},
       {Unused, "focal_distance focal_slope min_intensity max_intensity"}},
      "Elevation and azimuth of each laser (rad) and the place of its origin (m). Corrections of measured ranges and "
      "intensities count for nothing, since simulated ones have no such errors",
      ""};
  return format;
}

Value withCalibration(const Value& value, const Value* preset) {
  Fields fields(value, "sensor");
  if (!fields.has("calibration")) return value;
  constexpr const char* kWhy = "follows from the `calibration` beside it: leave one of them out";
  fields.refuse({"ring_order"}, kWhy);
  for (const auto& [key, member] : kRingKeys) fields.refuse({key}, kWhy);
  const Value& name = *value.find("calibration");
  const std::filesystem::path file = resolvePath(name, readText(name, "calibration"));
  Unit unit = readUnit(file, value, preset);
  const Value* const order = preset == nullptr ? nullptr : preset->find("ring_order");
  const std::string suffix = lowerExtension(file);
  const bool fileOrder = suffix == ".json" || suffix == ".csv";  // else the lasers come sorted from top to bottom
  if (order != nullptr && order->text == "bottom_up" && !fileOrder) std::ranges::reverse(unit.lasers);
  if (fileOrder && preset != nullptr) checkFiring(*preset, value, unit, name.where);
  const Location where{file.string()};
  Value sensor = value;
  std::erase_if(sensor.entries, [](const Value::Entry& e) { return e.key == "calibration"; });
  setEntry({"ring_order", scalar(orderOf(unit.lasers), where)}, sensor);
  addToSource(sensor, where);
  for (const auto& [key, member] : kRingKeys) setEntry({key, listOf(unit.lasers, member, where)}, sensor);
  if (!fields.has("firing_time_us") && hasFiring(unit)) {
    setEntry({"firing_time_us", listOf(unit.lasers, &Laser::firing, where)}, sensor);
  }
  for (Value::Entry& entry : unit.furtherKeys) {
    if (!fields.has(entry.key)) setEntry(std::move(entry), sensor);
  }
  return sensor;
}

}  // namespace scanmill
