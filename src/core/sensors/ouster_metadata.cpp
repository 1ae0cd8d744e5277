#include <fmt/core.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "base/format_support.h"
#include "base/vec.h"
#include "sensors/calibration.h"

namespace scanmill {
namespace {

using Json = nlohmann::json;

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file) : file_(file.string()) {
    try {
      root_ = Json::parse(readFile(file));
    } catch (const Json::exception& e) {
      fail(fmt::format("is not JSON: {}", reasonOf(e)));
    }
    if (!root_.is_object()) fail("is not the metadata of an Ouster sensor: it must be a map");
  }

  OusterMetadata read() {
    OusterMetadata m;
    if (const Json* line = find("sensor_info", "prod_line"); line != nullptr && line->is_string()) {
      m.model = line->get<std::string>();
    }
    readBeams(m);
    readMode(m);
    readWindow(m);
    readOrigin(m);
    leftOut_.tell(file_);
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
    if (const Json* const rows = format("pixels_per_column");
        rows != nullptr && *rows != m.elevation.size() && *rows != up.size()) {
      fail(fmt::format("has angles of {} beams, {} of which are unused, but its pixels_per_column are {}", up.size(),
                       up.size() - m.elevation.size(), rows->dump()));
    }
  }

  // Early firmware may lack the mode; the columns and the rate then stand in the format of the packets, or nowhere.
  void readMode(OusterMetadata& m) const {
    const Json* const mode = find("config_params", "lidar_mode");
    const std::string text = mode != nullptr && mode->is_string() ? mode->get<std::string>() : "";
    if (!text.empty()) {
      char rest = 0;
      unsigned rate = 0;
      if (std::sscanf(text.c_str(), "%ux%u%c", &m.columns, &rate, &rest) != 2 || m.columns == 0 || rate == 0 ||
          m.columns > kMostColumns || rate > kHighestRate) {
        fail(fmt::format("has the lidar_mode '{}', but it must be columns x revolutions per second, such as 1024x10",
                         text));
      }
      m.rate = rate;
    }
    const Json* const fps = format("fps");
    if (fps != nullptr) {
      const double said = number(*fps, "fps", 0.01, kHighestRate);
      if (m.rate != 0 && said != m.rate) {
        fail(fmt::format("has fps {:g} and the lidar_mode '{}': correct one of them", said, text));
      }
      m.rate = said;
    }
    const Json* const columns = format("columns_per_frame");
    if (columns == nullptr) return;
    const double count = number(*columns, "columns_per_frame", 1, kMostColumns);
    if (count != std::floor(count) || (m.columns != 0 && count != m.columns)) {
      fail(fmt::format("has columns_per_frame {:g} and the lidar_mode '{}': correct one of them", count, text));
    }
    m.columns = static_cast<std::uint32_t>(count);
  }

  const Json* format(const char* key) const {
    const Json* const found = find("lidar_data_format", key);
    if (found != nullptr) return found;
    const auto old = root_.find("data_format");
    if (old == root_.end() || !old->is_object() || !old->contains(key) || old->at(key).is_null()) return nullptr;
    return &old->at(key);
  }

  void readWindow(OusterMetadata& m) {
    m.windowColumns = m.columns;
    const Json* const window = format("column_window");
    const Json* const azimuths = find("config_params", "azimuth_window");
    // Firmware 1.13 counts in hundredths of a degree, later firmware in thousandths.
    const bool full = azimuths == nullptr || *azimuths == Json{0, 36000} || *azimuths == Json{0, 360000};
    const bool fullColumns = window == nullptr || *window == Json{0, m.columns - 1};
    if (!full && fullColumns) leftOut_.addKeyword(ousterFormat(), "azimuth_window");
    if (window == nullptr || m.columns == 0) return;
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

  void readOrigin(OusterMetadata& m) {
    // These are the default values of ouster-sdk.
    m.originOffset = m.model.starts_with("OS-0")   ? 0.02767
                     : m.model.starts_with("OS-1") ? 0.015806
                     : m.model.starts_with("OS-2") ? 0.013762
                                                   : 0.012163;
    m.originHeight = 0.03618;
    m.firstAzimuth = 180;
    if (const Json* offset = find("beam_intrinsics", "lidar_origin_to_beam_origin_mm")) {
      m.originOffset = number(*offset, "lidar_origin_to_beam_origin_mm", 0, kFarthestOrigin) * 1e-3;
    }
    if (const auto t = transform("lidar_intrinsics", "lidar_to_sensor_transform")) {
      m.firstAzimuth = degrees(std::atan2((*t)[4], (*t)[0]));
      m.originHeight = (*t)[11] * 1e-3;
      if ((*t)[3] != 0 || (*t)[7] != 0) failTransform("lidar_to_sensor_transform");
    }
    // If the beams' origins are above the lidar's, lidar_origin_to_beam_origin_mm is the length of both offsets.
    if (const auto t = transform("beam_intrinsics", "beam_to_lidar_transform")) {
      m.originOffset = (*t)[3] * 1e-3;
      m.originHeight += (*t)[11] * 1e-3;
      if (std::fabs((*t)[0] - 1) > kRounding || (*t)[7] != 0) failTransform("beam_to_lidar_transform");
    }
    const Json* const mount = find("ouster-sdk", "extrinsic");
    static const Json kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    if (mount != nullptr && *mount != kIdentity) leftOut_.addKeyword(ousterFormat(), "extrinsic");
    const Json* const start = find("config_params", "lidar_frame_azimuth_offset");
    if (start != nullptr && *start != 0) leftOut_.addKeyword(ousterFormat(), "lidar_frame_azimuth_offset");
  }

  double number(const Json& value, const char* key, double low, double high) const {
    if (value.is_number() && value.get<double>() >= low && value.get<double>() <= high) return value.get<double>();
    fail(fmt::format("{} must be a number from {:g} to {:g}, not {}", key, low, high, value.dump().substr(0, 40)));
  }

  [[noreturn]] void failTransform(const char* key) const {
    fail(
        fmt::format("{} tilts, mirrors or shifts the beams sideways, which is not read: set the key to null, and give "
                    "its transform by `mount`",
                    key));
  }

  // Returns the 16 numbers of a transform, row by row; nullopt if the file has none. Throws InputError unless the
  // transform rotates about z alone.
  std::optional<std::vector<double>> transform(const char* group, const char* key) const {
    const Json* const found = find(group, key);
    if (found == nullptr) return std::nullopt;
    const std::vector<double> t = numbers(*found, key);
    if (t.size() != 16) fail(fmt::format("{} must have 16 numbers", key));
    const double off = std::fabs(t[0] - t[5]) + std::fabs(t[1] + t[4]) + std::fabs(t[0] * t[0] + t[4] * t[4] - 1) +
                       std::fabs(t[2]) + std::fabs(t[6]) + std::fabs(t[8]) + std::fabs(t[9]) + std::fabs(t[10] - 1);
    if (off > kRounding) failTransform(key);
    return t;
  }

  static constexpr double kRounding = 1e-3;
  static constexpr double kFarthestOrigin = 1000;  // mm
  static constexpr std::uint32_t kMostColumns = 65536;
  static constexpr double kHighestRate = 1000;  // revolutions per second

  std::string file_;
  Json root_;
  LeftOut leftOut_;
};

}  // namespace

const FormatSupport& ousterFormat() {
  using enum FormatElements::Use;
  static const FormatSupport format{
      "Ouster metadata",
      ".json",
      {{LeftOut, "extrinsic", "extrinsic transforms, which `mount` gives"},
       {LeftOut, "azimuth_window", "azimuth windows that no column_window repeats"},
       {LeftOut, "lidar_frame_azimuth_offset", "azimuths at which frames begin"}},
      "Angles of the beams, where those of unused lasers are 0; columns and rate, for which a sensor's keys stand in "
      "if the file has neither; the part of the revolution that is sent; rotation about z and height of the lidar; "
      "places of the beams' origins, by default those of Ouster's software for the model",
      ""};
  return format;
}

OusterMetadata readOusterMetadata(const std::filesystem::path& file) {
  return Reader(file).read();
}

}  // namespace scanmill
