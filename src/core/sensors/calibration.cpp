#include "sensors/calibration.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "base/file.h"
#include "base/format_support.h"
#include "base/hash.h"
#include "config/fields.h"
#include "config/text.h"
#include "sensors/text_table.h"

namespace scanmill {

namespace {

constexpr std::array<std::string_view, 4> kChannelNames{"channel", "laserid", "laser_id", "ring"};

// Returns the indices of a table's rows, sorted by channel, or in the file's order if the table has no channels.
// Channels are numbered without gaps from 1, or from 0 if the table has a channel 0; otherwise InputError is thrown.
std::vector<std::size_t> rowsByChannel(const TextTable& table) {
  std::vector<std::size_t> rows(table.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  const auto name = std::ranges::find_first_of(table.names(), kChannelNames);
  if (name == table.names().end()) return rows;
  std::vector<double> channels;
  for (std::size_t row = 0; row < table.size(); ++row) channels.push_back(table.number(row, *name));
  const double firstChannel = std::ranges::find(channels, 0) == channels.end() ? 1 : 0;
  const double lastChannel = firstChannel + static_cast<double>(table.size()) - 1;
  std::vector<bool> isTaken(table.size());  // by channel, counted from the first channel
  for (std::size_t row = 0; row < table.size(); ++row) {
    const double channel = channels[row];
    if (channel != std::floor(channel) || channel < firstChannel || channel > lastChannel) {
      throw InputError(table.where(row), "has the channel {:g}, but a table of {} lines has the channels {:g} to {:g}",
                       channel, table.size(), firstChannel, lastChannel);
    }
    const auto index = static_cast<std::size_t>(channel - firstChannel);
    if (isTaken[index]) {
      throw InputError(table.where(row), "has the channel of an earlier line: give each channel one line");
    }
    isTaken[index] = true;
    rows[index] = row;
  }
  return rows;
}

// The keys per ring that a calibration sets, and for each key the member of Laser with its values.
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
  for (const Value::Entry& entry : file.entries) leftOut.addKeyword(kVelodyneFormat, entry.key);
  std::vector<Laser> lasers;
  for (const Value& item : items->items) {
    Fields laser(item, "laser");
    for (const Value::Entry& entry : item.entries) {
      laser.also({entry.key});
      leftOut.addKeyword(kVelodyneFormat, entry.key);
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

// Adds an entry to a map, or replaces the entry with the same key.
void setEntry(Value::Entry entry, Value& map) {
  std::erase_if(map.entries, [&](const Value::Entry& e) { return e.key == entry.key; });
  map.entries.push_back(std::move(entry));
}

// Returns a YAML list of the values of `member` of all lasers, in the lasers' order.
Value listOf(const std::vector<Laser>& lasers, double Laser::*member, const Location& where) {
  Value list = sequenceValue({}, where);
  for (const Laser& laser : lasers) list.items.push_back(scalarValue(fmt::format("{}", laser.*member), where));
  return list;
}

// Adds the calibration file's name and hash to the sensor's key `source`: the manifest then identifies the sensor unit.
void addToSource(Value& sensor, const Location& file) {
  const std::string calibration =
      fmt::format("calibration {} (SHA-256 {})", std::filesystem::path(file.file).filename().string(),
                  sha256(readFile(file.file)).substr(0, 16));
  const auto source = std::ranges::find(sensor.entries, "source", &Value::Entry::key);
  if (source != sensor.entries.end() && source->value.kind != Value::Kind::Null) {
    source->value.text += "; " + calibration;
    return;
  }
  Value text = scalarValue(calibration, file);
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
    unit.furtherKeys.push_back({key, scalarValue(text, where)});
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
  throw InputError(where,
                   "the firing times of the preset are for rings in the order {}, but the file "
                   "lists its lasers {}: reverse the lines of the file, or give firing_time_us",
                   presetOrder, fileOrder);
}

}  // namespace

const FormatSupport kVelodyneFormat{
    "Velodyne calibration",
    ".yaml",
    "Elevation and azimuth of each laser (rad) and the place of its origin (m). Corrections of measured ranges and "
    "intensities count for nothing, since simulated ones have no such errors",
    "",
    {.read = {"lasers num_lasers laser_id vert_correction rot_correction vert_offset_correction",
              "horiz_offset_correction"},
     .unused = {"dist_correction dist_correction_x dist_correction_y two_pt_correction_available",
                "distance_resolution focal_distance focal_slope min_intensity max_intensity"}}};

const FormatSupport kBeamTableFormat{
    "Table of lasers", ".csv",
    "Hesai's angle correction file (Channel, Elevation, Azimuth in degrees, clockwise) and firetime correction file, "
    "with one firing state; or a table of your own with elevation_deg, azimuth_offset_deg (counter-clockwise), "
    "origin_left_m, origin_up_m and firing_time_us"};

std::vector<Laser> readBeamTable(const std::filesystem::path& file) {
  const TextTable table(file);
  // Hesai's tables, whose azimuths are clockwise, have the column elevation instead of elevation_deg.
  const bool hesai = !table.has("elevation_deg");
  if (hesai && !table.has("elevation")) {
    throw InputError(table.head(),
                     "must name the columns, such as Channel,Elevation,Azimuth (Hesai) or "
                     "elevation_deg,azimuth_offset_deg");
  }
  std::vector<std::string> columns(kChannelNames.begin(), kChannelNames.end());
  if (hesai) {
    columns.insert(columns.end(), {"elevation", "azimuth"});
  } else {
    columns.insert(columns.end(),
                   {"elevation_deg", "azimuth_offset_deg", "origin_left_m", "origin_up_m", "firing_time_us"});
  }
  table.expectOnly(columns);
  std::vector<Laser> lasers;
  for (const std::size_t row : rowsByChannel(table)) {
    // Returns the row's number in a column; 0 if the table lacks the column.
    const auto number = [&](const char* name, double limit) { return table.number(row, name, {-limit, limit}); };
    const double elevation = number(hesai ? "elevation" : "elevation_deg", 90);
    const double azimuth = hesai ? 0 - number("azimuth", 360) : number("azimuth_offset_deg", 360);
    lasers.push_back({.elevation = elevation,
                      .azimuth = std::remainder(azimuth, 360.0),
                      .left = number("origin_left_m", 10),
                      .up = number("origin_up_m", 10),
                      .firing = number("firing_time_us", 1e8)});
  }
  return lasers;
}

std::vector<double> readFiringTable(const std::filesystem::path& file) {
  const TextTable table(file);
  constexpr std::array<std::string_view, 4> kTimeNames{"firing_time_us", "firetime_us", "even_firetime_ns",
                                                       "firetime_ns"};
  const auto* const name = std::ranges::find_if(kTimeNames, [&](std::string_view n) { return table.has(n); });
  if (name == kTimeNames.end()) {
    throw InputError(table.head(),
                     "must name the columns, such as Channel,fire time(us) or fire time(ns); files with several firing "
                     "states are not read: put the times of one state into a table with the column firing_time_us");
  }
  std::vector<double> times;
  for (const std::size_t row : rowsByChannel(table)) {
    times.push_back(table.number(row, *name));
    if (table.has("odd_firetime_ns") && table.number(row, "odd_firetime_ns") != times.back()) {
      throw InputError(table.head(),
                       "has two firing states, even and odd, with different times: put the times of one state into a "
                       "table with the column firing_time_us");
    }
  }
  const double earliest = std::ranges::min(times);
  for (double& time : times) time = (time - earliest) * (name->ends_with("us") ? 1 : 1e-3);
  return times;
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
  const bool fileOrder = suffix == ".json" || suffix == ".csv";  // else the lasers are sorted from top to bottom
  if (order != nullptr && order->text == "bottom_up" && !fileOrder) std::ranges::reverse(unit.lasers);
  if (fileOrder && preset != nullptr) checkFiring(*preset, value, unit, name.where);
  const Location where{file.string()};
  Value sensor = value;
  std::erase_if(sensor.entries, [](const Value::Entry& e) { return e.key == "calibration"; });
  setEntry({"ring_order", scalarValue(orderOf(unit.lasers), where)}, sensor);
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
