#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/error.h"
#include "base/file.h"
#include "base/format_support.h"
#include "base/vec.h"
#include "config/fields.h"
#include "sensors/beam_patterns.h"
#include "sensors/calibration.h"

namespace scanmill {
namespace {

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file) : file_(file.string()) {
    std::string text = readFile(file);
    std::ranges::replace(text, '\t', ' ');  // JSON without tabs is also YAML
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
  template <class... Values>
  [[noreturn]] void fail(fmt::format_string<Values...> problem, Values&&... values) const {
    throw InputError({file_}, fmt::format(problem, std::forward<Values>(values)...));
  }

  // Returns the value of a key in a group (new firmware) or at the top level (old firmware); null if it is missing.
  const Value* find(const char* group, const char* key) const {
    for (const Value* map : {&root_.valueOf(group), &root_}) {
      const Value* const found = map->kind == Value::Kind::Map ? map->find(key) : nullptr;
      if (found != nullptr && found->kind != Value::Kind::Null) return found;
    }
    return nullptr;
  }
  // Returns the value of a key of the packets' format; null if the file lacks the key.
  const Value* format(const char* key) const {
    const Value* const found = find("lidar_data_format", key);
    return found != nullptr ? found : find("data_format", key);
  }

  // Sets elevation and azimuth. Lasers whose two angles are 0 count as unused if there are several such lasers.
  void readBeams(OusterMetadata& m) const {
    const Value* const altitudeValue = find("beam_intrinsics", "beam_altitude_angles");
    const Value* const azimuthValue = find("beam_intrinsics", "beam_azimuth_angles");
    if (altitudeValue == nullptr || azimuthValue == nullptr) {
      fail("has no beam_altitude_angles and beam_azimuth_angles: is it the metadata of an Ouster sensor?");
    }
    if (!altitudeValue->items.empty() && altitudeValue->items.front().kind == Value::Kind::Sequence) {
      fail("has an angle for each pixel, as of a flash sensor (DF, ES): only metadata of spinning sensors is read");
    }
    const std::vector<double> altitudes = readNumbers(*altitudeValue, "beam_altitude_angles");
    const std::vector<double> azimuths = readNumbers(*azimuthValue, "beam_azimuth_angles");
    if (altitudes.empty() || altitudes.size() != azimuths.size()) {
      fail("has {} beam_altitude_angles and {} beam_azimuth_angles", altitudes.size(), azimuths.size());
    }
    std::size_t unused = 0;
    for (std::size_t i = 0; i < altitudes.size(); ++i) unused += altitudes[i] == 0 && azimuths[i] == 0 ? 1 : 0;
    for (std::size_t i = 0; i < altitudes.size(); ++i) {
      if (unused > 1 && altitudes[i] == 0 && azimuths[i] == 0) continue;
      if (std::fabs(altitudes[i]) > 90 || std::fabs(azimuths[i]) > 180) {
        fail("beam {} has the altitude {:g} and the azimuth {:g} deg", i, altitudes[i], azimuths[i]);
      }
      m.elevation.push_back(altitudes[i]);
      m.azimuth.push_back(azimuths[i] == 0 ? 0 : -azimuths[i]);
    }
    if (m.elevation.empty()) fail("gives all beams the angles 0");
    const Value* const pixelCount = format("pixels_per_column");
    const double pixels = pixelCount == nullptr ? 0 : readNumber(*pixelCount, "pixels_per_column");
    if (pixelCount != nullptr && pixels != static_cast<double>(m.elevation.size()) &&
        pixels != static_cast<double>(altitudes.size())) {
      fail("has angles of {} beams, {} of which are unused, but its pixels_per_column are {:g}", altitudes.size(),
           altitudes.size() - m.elevation.size(), pixels);
    }
  }

  // Sets columns and rate from the mode, such as 1024x10. Early firmware may lack the mode; the columns and the rate
  // are then read from the packets' format, if it states them.
  void readMode(OusterMetadata& m) const {
    const Value* const mode = find("config_params", "lidar_mode");
    const std::string text = mode == nullptr ? "" : mode->text;
    if (!text.empty()) {
      char trailing = 0;
      unsigned rate = 0;
      if (std::sscanf(text.c_str(), "%ux%u%c", &m.columns, &rate, &trailing) != 2 || m.columns == 0 || rate == 0 ||
          m.columns > kMostColumns || rate > kHighestRate) {
        fail("has the lidar_mode '{}', but it must be columns x revolutions per second, such as 1024x10", text);
      }
      m.rate = rate;
    }
    if (const Value* const fps = format("fps")) {
      const double hertz = readNumber(*fps, "fps", {0.01, kHighestRate});
      if (m.rate != 0 && hertz != m.rate) {
        fail("has fps {:g} and the lidar_mode '{}': correct one of them", hertz, text);
      }
      m.rate = hertz;
    }
    const Value* const columns = format("columns_per_frame");
    if (columns == nullptr) return;
    const double count = readNumber(*columns, "columns_per_frame", {1, kMostColumns});
    if (count != std::floor(count) || (m.columns != 0 && count != m.columns)) {
      fail("has columns_per_frame {:g} and the lidar_mode '{}': correct one of them", count, text);
    }
    m.columns = static_cast<std::uint32_t>(count);
  }

  // Sets firstColumn and windowColumns. readMode() must have set the columns. The window may continue from the last
  // column of the revolution to the first.
  void readWindow(OusterMetadata& m) {
    m.windowColumns = m.columns;
    const Value* const window = format("column_window");
    const Value* const azimuths = find("config_params", "azimuth_window");
    using Ends = std::vector<double>;  // first and last column, or first and last azimuth, of a window
    const Ends allColumns{0, m.columns - 1.0};
    const Ends columns = window == nullptr ? allColumns : readNumbers(*window, "column_window");
    // Firmware 1.13 counts azimuths in hundredths of a degree, later firmware in thousandths.
    const Ends azimuthEnds = azimuths == nullptr ? Ends{0, 360e3} : readNumbers(*azimuths, "azimuth_window");
    const bool allAzimuths = azimuthEnds == Ends{0, 36e3} || azimuthEnds == Ends{0, 360e3};
    if (!allAzimuths && columns == allColumns) leftOut_.addKeyword(kOusterFormat, "azimuth_window");
    if (window == nullptr || m.columns == 0) return;
    const auto isColumn = [&](double c) { return c >= 0 && c < m.columns && c == std::floor(c); };
    if (columns.size() != 2 || !isColumn(columns[0]) || !isColumn(columns[1])) {
      fail("has a column_window that is not [first, last] within its {} columns", m.columns);
    }
    m.firstColumn = static_cast<std::uint32_t>(columns[0]);
    const auto last = static_cast<std::uint32_t>(columns[1]);
    m.windowColumns = (last + m.columns - m.firstColumn) % m.columns + 1;
    if (m.windowColumns == 1 && m.columns > 1) fail("has a column_window of one column, but it must have at least two");
  }

  // Sets originOffset, originHeight and firstAzimuth. Transforms in the file are 4 x 4 matrices, listed row by row: [0]
  // and [4] are the cosine and the sine of the rotation about z; [3], [7] and [11] are the shift (mm).
  void readOrigin(OusterMetadata& m) {
    // The following values are defaults of ouster-sdk for files that lack them.
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
    // The transform replaces lidar_origin_to_beam_origin_mm, which is the length of the shift, not its horizontal part.
    if (const auto t = transform("beam_intrinsics", "beam_to_lidar_transform")) {
      m.originOffset = (*t)[3] * 1e-3;
      m.originHeight += (*t)[11] * 1e-3;
      if (std::fabs((*t)[0] - 1) > kRounding || (*t)[7] != 0) failTransform("beam_to_lidar_transform");
    }
    const Value* const mount = find("ouster-sdk", "extrinsic");
    const std::vector<double> identity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    if (mount != nullptr && readNumbers(*mount, "extrinsic") != identity)
      leftOut_.addKeyword(kOusterFormat, "extrinsic");
    const Value* const azimuthOffset = find("config_params", "lidar_frame_azimuth_offset");
    if (azimuthOffset != nullptr && readNumber(*azimuthOffset, "lidar_frame_azimuth_offset") != 0) {
      leftOut_.addKeyword(kOusterFormat, "lidar_frame_azimuth_offset");
    }
  }

  [[noreturn]] void failTransform(const char* key) const {
    fail(
        "{} tilts, mirrors or shifts the beams sideways, which is not read: set the key to null, and give "
        "its transform by `mount`",
        key);
  }

  // Returns the 16 numbers of a transform, row by row; nullopt if the file lacks it. Throws InputError unless the
  // transform's rotation is about z.
  std::optional<std::vector<double>> transform(const char* group, const char* key) const {
    const Value* const found = find(group, key);
    if (found == nullptr) return std::nullopt;
    const std::vector<double> t = readNumbers(*found, key);
    if (t.size() != 16) fail("{} must have 16 numbers", key);
    const double deviation = std::fabs(t[0] - t[5]) + std::fabs(t[1] + t[4]) +
                             std::fabs(t[0] * t[0] + t[4] * t[4] - 1) + std::fabs(t[2]) + std::fabs(t[6]) +
                             std::fabs(t[8]) + std::fabs(t[9]) + std::fabs(t[10] - 1);
    if (deviation > kRounding) failTransform(key);
    return t;
  }

  static constexpr double kRounding = 1e-3;        // largest error of a transform's numbers, which are rounded
  static constexpr double kFarthestOrigin = 1000;  // mm
  static constexpr double kHighestRate = 1000;     // revolutions per second

  std::string file_;
  Value root_;
  LeftOut leftOut_;
};

}  // namespace

const FormatSupport kOusterFormat{
    "Ouster metadata",
    ".json",
    "Angles of the beams, where those of unused lasers are 0; columns and rate, for which a sensor's keys stand in "
    "if the file has neither; the part of the revolution that is sent; rotation about z and height of the lidar; "
    "places of the beams' origins, by default those of Ouster's software for the model",
    "",
    {.leftOut = {{"extrinsic", "extrinsic transforms, which `mount` gives"},
                 {"azimuth_window", "azimuth windows that no column_window repeats"},
                 {"lidar_frame_azimuth_offset", "azimuths at which frames begin"}}}};

OusterMetadata readOusterMetadata(const std::filesystem::path& file) {
  return Reader(file).read();
}

}  // namespace scanmill
