#include "sensors/calibration.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/file.h"
#include "base/format_support.h"
#include "base/hash.h"
#include "config/fields.h"
#include "config/text.h"

namespace scanmill {

namespace {

// The keys that follow from a calibration, besides ring_order.
constexpr std::pair<const char*, double Laser::*> kMadeKeys[] = {{"elevation_deg", &Laser::elevation},
                                                                 {"azimuth_offset_deg", &Laser::azimuth},
                                                                 {"origin_left_m", &Laser::left},
                                                                 {"origin_up_m", &Laser::up}};

// Reads a file of Velodyne's ROS drivers; sorts the lasers from top to bottom.
std::vector<Laser> readLasers(const Value& file) {
  const Value* lasers = file.find("lasers");
  if (file.kind != Value::Kind::Map || lasers == nullptr || lasers->kind != Value::Kind::Sequence ||
      lasers->items.empty()) {
    throw InputError(file.where,
                     "is not a calibration: it must be a map with a list `lasers`, as in the ROS drivers of Velodyne "
                     "sensors; Ouster's metadata need the suffix .json, tables of beams .csv");
  }
  LeftOut leftOut;
  for (const Value::Entry& entry : file.entries) leftOut.addKeyword(velodyneFormat(), entry.key);
  std::vector<Laser> read;
  for (const Value& item : lasers->items) {
    Fields laser(item, "laser");
    for (const Value::Entry& entry : item.entries) {
      laser.also({entry.key});
      leftOut.addKeyword(velodyneFormat(), entry.key);
    }
    const auto angle = [&](const char* key, double most) {
      return degrees(readNumber(laser.require(key), fmt::format("laser: {} (rad)", key), {-most, most}));
    };
    const auto offset = [&](const char* key) {
      constexpr double kMost = 0.5;  // m; the largest sensor has 0.22 m
      const Value* const value = laser.find(key);
      return value == nullptr ? 0 : readNumber(*value, fmt::format("laser: {} (m)", key), {-kMost, kMost});
    };
    read.push_back({angle("vert_correction", kPi / 2), angle("rot_correction", kPi), offset("horiz_offset_correction"),
                    offset("vert_offset_correction"), 0});
  }
  leftOut.warn(file.where.file);
  std::stable_sort(read.begin(), read.end(), [](const Laser& a, const Laser& b) { return a.elevation > b.elevation; });
  return read;
}

Value scalar(const std::string& text, const Location& where) {
  Value value;
  value.kind = Value::Kind::Scalar;
  value.where = where;
  value.text = text;
  return value;
}

// Gives a map a key, in place of an empty one.
void give(Value::Entry entry, Value& map) {
  std::erase_if(map.entries, [&](const Value::Entry& e) { return e.key == entry.key; });
  map.entries.push_back(std::move(entry));
}

Value::Entry listOf(const char* key, const std::vector<Laser>& lasers, double Laser::*figure, const Location& where) {
  Value list;
  list.kind = Value::Kind::Sequence;
  list.where = where;
  for (const Laser& laser : lasers) list.items.push_back(scalar(fmt::format("{}", laser.*figure), where));
  return {key, std::move(list)};
}

// Adds the calibration file's name and hash to the sensor's key `source`, so that the manifest identifies the sensor
// unit.
void setSource(Value& sensor, const Location& file) {
  const std::string own =
      fmt::format("calibration {} (SHA-256 {})", std::filesystem::path(file.file).filename().string(),
                  sha256(readFile(file.file)).substr(0, 16));
  const auto said = std::find_if(sensor.entries.begin(), sensor.entries.end(),
                                 [](const Value::Entry& e) { return e.key == "source"; });
  if (said != sensor.entries.end() && said->value.kind != Value::Kind::Null) {
    said->value.text += "; " + own;
    return;
  }
  Value source = scalar(own, file);
  source.quoted = true;
  give({"source", std::move(source)}, sensor);
}

// Returns the value of the key `ring_order` that describes the order of these lasers.
const char* orderOf(const std::vector<Laser>& lasers) {
  const auto above = [](const Laser& a, const Laser& b) { return a.elevation > b.elevation; };
  const auto below = [](const Laser& a, const Laser& b) { return a.elevation < b.elevation; };
  if (std::is_sorted(lasers.begin(), lasers.end(), above)) return "top_down";
  return std::is_sorted(lasers.begin(), lasers.end(), below) ? "bottom_up" : "unordered";
}

// The contents of a calibration file.
struct Unit {
  std::vector<Laser> lasers;
  std::vector<Value::Entry> others;  // further keys; the same keys in the sensor file replace them
};

// Reads Ouster's metadata. Takes only the columns that the sensor sends according to the file or, if `value` states
// columns or a field, all columns of the revolution. Throws InputError if the file lacks the columns or the rate, and
// neither `value` nor `preset` (null: none) has them.
Unit unitOfOuster(const std::filesystem::path& file, const Value& value, const Value* preset) {
  const Fields own(value, "sensor");
  const bool window = !own.has("columns") && !own.has("field_deg");
  const OusterMetadata m = readOusterMetadata(file);
  const auto has = [&](const char* key) {
    return own.has(key) || (preset != nullptr && Fields(*preset, "preset").has(key));
  };
  if ((m.columns == 0 && !has("columns")) || (m.rate == 0 && !has("rate_hz"))) {
    throw InputError({file.string()},
                     "has no lidar_mode, which states the columns and the rate: give `columns` and `rate_hz` beside "
                     "`calibration`");
  }
  Unit unit;
  for (std::size_t i = 0; i < m.elevation.size(); ++i) {
    unit.lasers.push_back({.elevation = m.elevation[i], .azimuth = m.azimuth[i]});
  }
  const Location where{file.string()};
  const auto add = [&](const char* key, const std::string& text) { unit.others.push_back({key, scalar(text, where)}); };
  const double step = m.columns == 0 ? 0 : 360.0 / m.columns;
  const std::uint32_t columns = window ? m.windowColumns : m.columns;
  const std::uint32_t first = window ? m.firstColumn : 0;
  if (!m.model.empty()) add("model", m.model);
  if (columns > 0) add("columns", std::to_string(columns));
  if (m.rate > 0) add("rate_hz", fmt::format("{}", m.rate));
  add("direction", "clockwise");
  add("first_azimuth_deg", fmt::format("{}", std::remainder(m.firstAzimuth - step * first, 360.0)));
  add("origin_offset_m", fmt::format("{}", m.originOffset));
  add("origin_height_m", fmt::format("{}", m.originHeight));
  if (columns < m.columns) add("field_deg", fmt::format("{}", step * (columns - 1)));
  return unit;
}

Unit readUnit(const std::filesystem::path& file, const Value& value, const Value* preset) {
  const std::string kind = lowerExtension(file);
  if (kind == ".json") return unitOfOuster(file, value, preset);
  if (kind == ".csv") return {readBeamTable(file), {}};
  if (kind == ".dat") {
    throw InputError({file.string()},
                     "is a correction file of a Hesai sensor with mirrors, whose beams do not lie on cones: such files "
                     "are not read");
  }
  if (kind == ".xml") {
    throw InputError({file.string()},
                     "is a calibration of VeloView, in degrees and centimetres: convert it with gen_calibration.py of "
                     "velodyne_pointcloud, which writes the .yaml that is read");
  }
  return {readLasers(readYaml(file)), {}};
}

bool hasFiring(const Unit& unit) {
  return std::any_of(unit.lasers.begin(), unit.lasers.end(), [](const Laser& l) { return l.firing != 0; });
}

// Throws InputError if the firing times come from the preset, but the file lists its lasers in the reverse order of the
// preset's rings.
void checkFiring(const Value& preset, const Value& own, const Unit& unit, const Location& where) {
  if (preset.find("firing_time_us") == nullptr || own.find("firing_time_us") != nullptr || hasFiring(unit)) return;
  const Value* const order = preset.find("ring_order");
  const std::string theirs = order == nullptr ? "top_down" : order->text;
  const std::string ours = orderOf(unit.lasers);
  if (theirs == ours || theirs == "unordered" || ours == "unordered") return;
  throw InputError(where, fmt::format("the firing times of the preset are for rings in the order {}, but the file "
                                      "lists its lasers {}: reverse the lines of the file, or give firing_time_us",
                                      theirs, ours));
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
  for (const auto& [key, figure] : kMadeKeys) fields.refuse({key}, kWhy);
  const Value& name = *value.find("calibration");
  const std::filesystem::path file = resolvePath(name, readText(name, "calibration"));
  Unit unit = readUnit(file, value, preset);
  const Value* const order = preset == nullptr ? nullptr : preset->find("ring_order");
  const std::string kind = lowerExtension(file);
  const bool listed = kind == ".json" || kind == ".csv";
  if (order != nullptr && order->text == "bottom_up" && !listed) std::reverse(unit.lasers.begin(), unit.lasers.end());
  if (listed && preset != nullptr) checkFiring(*preset, value, unit, name.where);
  const Location where{file.string()};
  Value sensor = value;
  std::erase_if(sensor.entries, [](const Value::Entry& e) { return e.key == "calibration"; });
  give({"ring_order", scalar(orderOf(unit.lasers), where)}, sensor);
  setSource(sensor, where);
  for (const auto& [key, figure] : kMadeKeys) give(listOf(key, unit.lasers, figure, where), sensor);
  if (!fields.has("firing_time_us") && hasFiring(unit)) {
    give(listOf("firing_time_us", unit.lasers, &Laser::firing, where), sensor);
  }
  for (Value::Entry& entry : unit.others) {
    if (!fields.has(entry.key)) give(std::move(entry), sensor);
  }
  return sensor;
}

}  // namespace scanmill
