#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/error.h"
#include "base/file.h"
#include "base/format_support.h"
#include "base/vec.h"
#include "config/fields.h"
#include "sensors/calibration.h"

namespace scanmill {
namespace {

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file) : file_(file.string()) {
    std::string text = readFile(file);
    std::replace(text.begin(), text.end(), '\t', ' ');  // JSON is YAML but for its tabs
    root_ = parseYaml(text, file_);
    if (root_.kind != Value::Kind::Map) fail("is not the metadata of an Ouster sensor: it must be a map");
  }

  OusterMetadata read() {
    OusterMetadata m;
    if (const Value* line = find("sensor_info", "prod_line")) m.model = line->text;
    readBeams(m);
    readMode(m);
    readWindow(m);
    readOrigin(m);
    leftOut_.warn(file_);
    return m;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError({file_}, what); }

  // Returns the value of a key in a group (new firmware) or at the top level (old firmware); null if the key is
  // in neither place.
  const Value* find(const char* group, const char* key) const {
    for (const Value* map : {&root_.valueOf(group), &root_}) {
      const Value* const found = map->kind == Value::Kind::Map ? map->find(key) : nullptr;
      if (found != nullptr && found->kind != Value::Kind::Null) return found;
    }
    return nullptr;
  }
  const Value* format(const char* key) const {
    const Value* const found = find("lidar_data_format", key);
    return found != nullptr ? found : find("data_format", key);
  }

  void readBeams(OusterMetadata& m) const {
    const Value* const altitude = find("beam_intrinsics", "beam_altitude_angles");
    const Value* const azimuth = find("beam_intrinsics", "beam_azimuth_angles");
    if (altitude == nullptr || azimuth == nullptr) {
      fail("has no beam_altitude_angles and beam_azimuth_angles: is it the metadata of an Ouster sensor?");
    }
    if (!altitude->items.empty() && altitude->items.front().kind == Value::Kind::Sequence) {
      fail("has an angle for each pixel, as of a flash sensor (DF, ES): only metadata of spinning sensors is read");
    }
    const std::vector<double> up = readNumbers(*altitude, "beam_altitude_angles");
    const std::vector<double> around = readNumbers(*azimuth, "beam_azimuth_angles");
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
    const Value* const rows = format("pixels_per_column");
    const double pixels = rows == nullptr ? 0 : readNumber(*rows, "pixels_per_column");
    if (rows != nullptr && pixels != static_cast<double>(m.elevation.size()) &&
        pixels != static_cast<double>(up.size())) {
      fail(fmt::format("has angles of {} beams, {} of which are unused, but its pixels_per_column are {:g}", up.size(),
                       up.size() - m.elevation.size(), pixels));
    }
  }

  // Early firmware may lack the mode; the columns and the rate then stand in the format of the packets, or nowhere.
  void readMode(OusterMetadata& m) const {
    const Value* const mode = find("config_params", "lidar_mode");
    const std::string text = mode == nullptr ? "" : mode->text;
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
    if (const Value* const fps = format("fps")) {
      const double said = readNumber(*fps, "fps", {0.01, kHighestRate});
      if (m.rate != 0 && said != m.rate) {
        fail(fmt::format("has fps {:g} and the lidar_mode '{}': correct one of them", said, text));
      }
      m.rate = said;
    }
    const Value* const columns = format("columns_per_frame");
    if (columns == nullptr) return;
    const double count = readNumber(*columns, "columns_per_frame", {1, kMostColumns});
    if (count != std::floor(count) || (m.columns != 0 && count != m.columns)) {
      fail(fmt::format("has columns_per_frame {:g} and the lidar_mode '{}': correct one of them", count, text));
    }
    m.columns = static_cast<std::uint32_t>(count);
  }

  void readWindow(OusterMetadata& m) {
    m.windowColumns = m.columns;
    const Value* const window = format("column_window");
    const Value* const azimuths = find("config_params", "azimuth_window");
    using Ends = std::vector<double>;
    const Ends turn = azimuths == nullptr ? Ends{0, 360e3} : readNumbers(*azimuths, "azimuth_window");
    const Ends ends = window == nullptr ? Ends{0, m.columns - 1.0} : readNumbers(*window, "column_window");
    // Firmware 1.13 counts in hundredths of a degree, later firmware in thousandths.
    const bool full = turn == Ends{0, 36e3} || turn == Ends{0, 360e3};
    if (!full && ends == Ends{0, m.columns - 1.0}) leftOut_.addKeyword(ousterFormat(), "azimuth_window");
    if (window == nullptr || m.columns == 0) return;
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
    if (const Value* offset = find("beam_intrinsics", "lidar_origin_to_beam_origin_mm")) {
      m.originOffset = readNumber(*offset, "lidar_origin_to_beam_origin_mm", {0, kFarthestOrigin}) * 1e-3;
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
    const Value* const mount = find("ouster-sdk", "extrinsic");
    const std::vector<double> none{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    if (mount != nullptr && readNumbers(*mount, "extrinsic") != none) leftOut_.addKeyword(ousterFormat(), "extrinsic");
    const Value* const start = find("config_params", "lidar_frame_azimuth_offset");
    if (start != nullptr && readNumber(*start, "lidar_frame_azimuth_offset") != 0) {
      leftOut_.addKeyword(ousterFormat(), "lidar_frame_azimuth_offset");
    }
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
    const Value* const found = find(group, key);
    if (found == nullptr) return std::nullopt;
    const std::vector<double> t = readNumbers(*found, key);
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
  Value root_;
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
