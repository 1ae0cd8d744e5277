#include <fmt/core.h>

#include <algorithm>

#include "base/terminal.h"
#include "base/text_scan.h"
#include "commands/info.h"
#include "commands/table.h"
#include "config/file_kind.h"
#include "config/text.h"
#include "pipeline/read/effects.h"
#include "sensors/sensor.h"

namespace scanmill {

namespace {

void printBeams(const BeamTable& beams) {
  Rows rows{{"ring", "elevation deg", "azimuth offset deg", "firing us"}};
  const bool ownOrigins = !beams.originLeft.empty() || !beams.originUp.empty();
  if (ownOrigins) rows.front().insert(rows.front().end(), {"origin left mm", "origin up mm"});
  for (std::uint32_t r = 0; r < beams.rings; ++r) {
    const auto at = [&](const std::vector<double>& column) { return r < column.size() ? column[r] : 0.0; };
    rows.push_back({std::to_string(r), fmt::format("{:.3f}", degrees(at(beams.elevation))),
                    fmt::format("{:.3f}", degrees(at(beams.azimuthOffset))),
                    fmt::format("{:.3f}", at(beams.firingOffset) * 1e6)});
    if (!ownOrigins) continue;
    rows.back().push_back(fmt::format("{:.1f}", at(beams.originLeft) * 1000));
    rows.back().push_back(fmt::format("{:.1f}", at(beams.originUp) * 1000));
  }
  printText("{}", formatTable(rows));
}

}  // namespace

std::array<double, 2> fieldOf(const BeamTable& beams) {
  std::vector<double> azimuths;
  double lowest = kPi / 2;
  double highest = -kPi / 2;
  for (const Vec3d& d : beams.direction) {
    const double elevation = std::asin(std::clamp(d.z, -1.0, 1.0));
    lowest = std::min(lowest, elevation);
    highest = std::max(highest, elevation);
    azimuths.push_back(std::atan2(d.y, d.x));
  }
  std::ranges::sort(azimuths);
  double gap = azimuths.front() + 2 * kPi - azimuths.back();
  for (std::size_t i = 1; i < azimuths.size(); ++i) gap = std::max(gap, azimuths[i] - azimuths[i - 1]);
  return {gap < radians(5) ? 360 : degrees(2 * kPi - gap), degrees(highest - lowest)};
}

void printSensor(const Value& sensor) {
  checkSensorEffects(sensor, nullptr);
  const auto beams = makeBeams(sensor);
  printText("sensor {}: {} rings x {} columns, {:.3g} revolutions/s, {}, ring 0 is the {} beam\nsource: {}\n",
            beams->model, beams->rings, beams->columns, 1 / beams->period,
            beams->clockwise ? "clockwise" : "counter-clockwise", beams->topDown ? "top" : "bottom", beams->source);
  printText("range {:.3g} to {:.3g} m; column 0 at {:.2f} deg; beams start {:.2f} mm off the axis\n\n", beams->minRange,
            beams->maxRange, degrees(beams->firstAzimuth), beams->originOffset * 1000);
  if (beams->onCones()) return printBeams(*beams);
  const std::array<double, 2> field = fieldOf(*beams);
  printText("directions differ from beam to beam in a field of {:.3g} x {:.3g} deg\n", field[0], field[1]);
}

bool isCalibration(const std::filesystem::path& file) {
  const std::string kind = lowerExtension(file);
  if (kind != ".json" && kind != ".csv") return false;
  const std::string text = firstBytes(file, std::size_t{1} << 20);  // scans and tilesets may be large
  if (kind == ".json") return text.find("\"beam_altitude_angles\"") != std::string::npos;
  const std::string head = lowerCase(std::string_view(text).substr(0, text.find('\n')));
  const char separator = head.find(';') == head.npos ? ',' : ';';
  std::vector<std::string_view> names;
  splitCells(head, separator, names);
  const auto has = [&](std::string_view name) { return std::ranges::find(names, name) != names.end(); };
  // Scans have x or easting; tables of single beams have azimuth_deg.
  return (has("elevation") || has("elevation_deg")) && !has("x") && !has("easting") && !has("azimuth_deg");
}

}  // namespace scanmill
