#include "sensors/ouster_metadata.h"

#include <fmt/core.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "base/vec.h"

namespace scanmill {
namespace {

using Json = nlohmann::json;

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file) : file_(file.string()) {
    try {
      root_ = Json::parse(readFile(file));
    } catch (const Json::exception& e) {
      fail(fmt::format("is not JSON: {}", e.what()));
    }
    if (!root_.is_object()) fail("is not the metadata of an Ouster sensor: it must be a map");
  }

  OusterMetadata read() const {
    OusterMetadata m;
    if (const Json* line = find("sensor_info", "prod_line"); line != nullptr && line->is_string()) {
      m.model = line->get<std::string>();
    }
    readBeams(m);
    readMode(m);
    readWindow(m);
    readOrigin(m);
    return m;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError({file_}, what); }

  // Returns the value of a key in a group (new firmware) or at the top level (old firmware); null if the key is
  // in neither place.
  const Json* find(const char* group, const char* key) const {
    if (const auto g = root_.find(group); g != root_.end() && g->is_object()) {
      if (const auto found = g->find(key); found != g->end() && !found->is_null()) return &*found;
    }
    const auto found = root_.find(key);
    return found == root_.end() || found->is_null() ? nullptr : &*found;
  }

  std::vector<double> numbers(const Json& list, const char* key) const {
    if (!list.is_array()) fail(fmt::format("{} must be a list of numbers", key));
    std::vector<double> read;
    for (const Json& item : list) {
      if (!item.is_number() || !std::isfinite(item.get<double>())) {
        fail(fmt::format("{}: entry {} must be a number", key, read.size()));
      }
      read.push_back(item.get<double>());
    }
    return read;
  }

  void readBeams(OusterMetadata& m) const {
    const Json* const altitude = find("beam_intrinsics", "beam_altitude_angles");
    const Json* const azimuth = find("beam_intrinsics", "beam_azimuth_angles");
    if (altitude == nullptr || azimuth == nullptr) {
      fail("has no beam_altitude_angles and beam_azimuth_angles: is it the metadata of an Ouster sensor?");
    }
    if (!altitude->empty() && altitude->front().is_array()) {
      fail("has an angle for each pixel, as of a flash sensor (DF, ES): only metadata of spinning sensors is read");
    }
    const std::vector<double> up = numbers(*altitude, "beam_altitude_angles");
    const std::vector<double> around = numbers(*azimuth, "beam_azimuth_angles");
    if (up.empty() || up.size() != around.size()) {
      fail(fmt::format("has {} beam_altitude_angles and {} beam_azimuth_angles", up.size(), around.size()));
    }
    std::size_t unused = 0;
    for (std::size_t i = 0; i < up.size(); ++i) unused += up[i] == 0 && around[i] == 0 ? 1 : 0;
    for (std::size_t i = 0; i < up.size(); ++i) {
      if (unused > 1 && up[i] == 0 && around[i] == 0) continue;
      if (std::fabs(up[i]) > 90 || std::fabs(around[i]) > 180) {
        fail(fmt::format("beam {} has the altitude {:g} and the azimuth {:g} deg", i, up[i], around[i]));
      }
      m.elevation.push_back(up[i]);
      m.azimuth.push_back(around[i] == 0 ? 0 : -around[i]);
    }
    if (m.elevation.empty()) fail("gives all beams the angles 0");
  }

  void readMode(OusterMetadata& m) const {
    const Json* const mode = find("config_params", "lidar_mode");
    unsigned columns = 0;
    unsigned rate = 0;
    char rest = 0;
    const std::string text = mode != nullptr && mode->is_string() ? mode->get<std::string>() : "";
    if (std::sscanf(text.c_str(), "%ux%u%c", &columns, &rate, &rest) != 2 || columns == 0 || rate == 0 ||
        columns > 65536 || rate > 1000) {
      fail(fmt::format("has the lidar_mode '{}', but it must be columns x revolutions per second, such as 1024x10",
                       text));
    }
    m.columns = columns;
    m.rate = rate;
  }

  const Json* format(const char* key) const {
    const Json* const found = find("lidar_data_format", key);
    if (found != nullptr) return found;
    const auto old = root_.find("data_format");
    if (old == root_.end() || !old->is_object() || !old->contains(key)) return nullptr;
    return &old->at(key);
  }

  void readWindow(OusterMetadata& m) const {
    m.windowColumns = m.columns;
    const Json* const window = format("column_window");
    if (window == nullptr) return;
    const std::vector<double> ends = numbers(*window, "column_window");
    const auto isColumn = [&](double c) { return c >= 0 && c < m.columns && c == std::floor(c); };
    if (ends.size() != 2 || !isColumn(ends[0]) || !isColumn(ends[1])) {
      fail(fmt::format("has a column_window that is not [first, last] within its {} columns", m.columns));
    }
    m.firstColumn = static_cast<std::uint32_t>(ends[0]);
    const auto last = static_cast<std::uint32_t>(ends[1]);
    m.windowColumns = (last + m.columns - m.firstColumn) % m.columns + 1;
    if (m.windowColumns == 1 && m.columns > 1) fail("has a column_window of one column, but it must have at least two");
  }

  void readOrigin(OusterMetadata& m) const {
    // These are the default values of ouster-sdk.
    m.originOffset = m.model.starts_with("OS-0")   ? 0.02767
                     : m.model.starts_with("OS-1") ? 0.015806
                     : m.model.starts_with("OS-2") ? 0.013762
                                                   : 0.012163;
    m.originHeight = 0.03618;
    m.firstAzimuth = 180;
    if (const Json* offset = find("beam_intrinsics", "lidar_origin_to_beam_origin_mm")) {
      if (!offset->is_number()) fail("lidar_origin_to_beam_origin_mm must be a number");
      m.originOffset = offset->get<double>() * 1e-3;
    }
    const Json* const transform = find("lidar_intrinsics", "lidar_to_sensor_transform");
    if (transform == nullptr) return;
    const std::vector<double> t = numbers(*transform, "lidar_to_sensor_transform");
    if (t.size() != 16) fail("lidar_to_sensor_transform must have 16 numbers");
    m.firstAzimuth = degrees(std::atan2(t[4], t[0]));
    m.originHeight = t[11] * 1e-3;
  }

  std::string file_;
  Json root_;
};

}  // namespace

OusterMetadata readOusterMetadata(const std::filesystem::path& file) {
  return Reader(file).read();
}

}  // namespace scanmill
