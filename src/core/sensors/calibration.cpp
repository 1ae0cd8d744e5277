#include "sensors/calibration.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "base/file.h"
#include "base/hash.h"
#include "config/fields.h"

namespace scanmill {

namespace {

constexpr std::array<const char*, 5> kMadeKeys{"elevation_deg", "ring_order", "azimuth_offset_deg", "origin_left_m",
                                               "origin_up_m"};

struct Laser {
  double elevation = 0;  // deg
  double azimuth = 0;    // deg, counter-clockwise
  double left = 0;       // m
  double up = 0;         // m
};

std::vector<Laser> readLasers(const Value& file) {
  const Value* lasers = file.find("lasers");
  if (file.kind != Value::Kind::Map || lasers == nullptr || lasers->kind != Value::Kind::Sequence ||
      lasers->items.empty()) {
    throw InputError(file.where,
                     "no calibration: it must be a map with a list `lasers`, as the ROS drivers of Velodyne sensors "
                     "keep it");
  }
  std::vector<Laser> read;
  for (const Value& item : lasers->items) {
    Fields laser(item, "laser");
    Laser l;
    l.elevation = degrees(laser.number("vert_correction", {-kPi / 2, kPi / 2}));
    l.azimuth = degrees(laser.number("rot_correction", {-kPi, kPi}));
    l.left = laser.number("horiz_offset_correction", {-10, 10}, 0);
    l.up = laser.number("vert_offset_correction", {-10, 10}, 0);
    read.push_back(l);
  }
  std::stable_sort(read.begin(), read.end(), [](const Laser& a, const Laser& b) { return a.elevation > b.elevation; });
  return read;
}

Value::Entry listOf(const char* key, const std::vector<Laser>& lasers, double Laser::*figure, const Location& where) {
  Value list;
  list.kind = Value::Kind::Sequence;
  list.where = where;
  for (const Laser& laser : lasers) {
    Value item;
    item.kind = Value::Kind::Scalar;
    item.where = where;
    item.text = fmt::format("{}", laser.*figure);
    list.items.push_back(std::move(item));
  }
  return {key, std::move(list)};
}

// The manifest names the unit, by its file and what that holds.
void setSource(Value& sensor, const Location& file) {
  const std::string own =
      fmt::format("calibration {} (SHA-256 {})", std::filesystem::path(file.file).filename().string(),
                  sha256(readFile(file.file)).substr(0, 16));
  const auto said = std::find_if(sensor.entries.begin(), sensor.entries.end(),
                                 [](const Value::Entry& e) { return e.key == "source"; });
  if (said != sensor.entries.end()) {
    said->value.text += "; " + own;
    return;
  }
  Value source;
  source.kind = Value::Kind::Scalar;
  source.where = file;
  source.quoted = true;
  source.text = own;
  sensor.entries.push_back({"source", std::move(source)});
}

}  // namespace

Value withCalibration(const Value& value) {
  if (value.kind != Value::Kind::Map || value.find("calibration") == nullptr) return value;
  for (const char* key : kMadeKeys) {
    const Value* other = value.find(key);
    if (other == nullptr) continue;
    throw InputError(other->where,
                     fmt::format("`{}` follows from the `calibration` beside it: leave one of them out", key));
  }
  const Value& name = *value.find("calibration");
  const Value file = readYaml(resolvePath(name, readText(name, "calibration")));
  const std::vector<Laser> lasers = readLasers(file);
  Value sensor = value;
  std::erase_if(sensor.entries, [](const Value::Entry& e) { return e.key == "calibration"; });
  Value order;
  order.kind = Value::Kind::Scalar;
  order.where = file.where;
  order.text = "top_down";
  sensor.entries.push_back({"ring_order", std::move(order)});
  setSource(sensor, file.where);
  sensor.entries.push_back(listOf("elevation_deg", lasers, &Laser::elevation, file.where));
  sensor.entries.push_back(listOf("azimuth_offset_deg", lasers, &Laser::azimuth, file.where));
  sensor.entries.push_back(listOf("origin_left_m", lasers, &Laser::left, file.where));
  sensor.entries.push_back(listOf("origin_up_m", lasers, &Laser::up, file.where));
  return sensor;
}

}  // namespace scanmill
