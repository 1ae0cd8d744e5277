#include "study/sensor/fit_sensor.h"

#include <fmt/chrono.h>
#include <fmt/core.h>

#include <chrono>
#include <filesystem>

#include "base/file.h"
#include "base/grouped.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/command.h"
#include "commands/recorded_scans.h"

namespace scanmill {

int runFitSensor(const std::vector<std::string>& arguments) {
  const Command& command = commandNamed("fit-sensor");
  cxxopts::Options options = describe(command);
  options.add_options()("o,out", "the sensor file to write", cxxopts::value<std::string>(), "FILE")("overwrite",
                                                                                                    "replace the file");
  const Arguments parsed = parseArguments(
      command, options, arguments,
      "  scanmill fit-sensor frames/*.pcd -o my_sensor.yaml\n"
      "The scans must be organised or have the columns ring and column; their points must be in the sensor's frame.\n");
  if (parsed.help) return 0;
  if (parsed.options.count("input") == 0) throw InputError("SCAN is missing; see --help");
  const auto files = parsed.options["input"].as<std::vector<std::string>>();
  const std::filesystem::path out = requiredFile(parsed, "name the sensor file to write, such as my_sensor.yaml");
  std::vector<Scan> scans;
  forEachScan(files, [&](const Scan& scan, const std::string&) { scans.push_back(scan); });
  const SensorFit fit = fitSensor(scans);

  printText("fitted to {} points of {} scans: {} rings x {} columns over {}\n", grouped(fit.points), scans.size(),
            fit.rings, fit.columns,
            fit.field > 2 * kPi - 1e-9 ? std::string("a full turn") : fmt::format("{:.2f} deg", degrees(fit.field)));
  printText("half of the points lie within {:.4f} deg of their ring's elevation and {:.4f} deg of its azimuth\n",
            degrees(fit.elevationSpread), degrees(fit.azimuthSpread));
  constexpr double kOff = 0.1;  // largest spread (degrees) that errors of a sensor explain
  if (degrees(std::max(fit.elevationSpread, fit.azimuthSpread)) > kOff) {
    warn(
        "this is more than the errors of a sensor: the points must be in the sensor's frame, not the vehicle's, and "
        "not deskewed");
  }
  if (!fit.bareRings.empty()) {
    warn(
        fmt::format("{} rings (the first is {}) have too few points, so their elevations are interpolated between "
                    "other rings: name more scans",
                    fit.bareRings.size(), fit.bareRings.front()));
  }
  const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  const std::string yaml = sensorYaml(fit, fmt::format("fitted to {} points of {} scans, {:%Y-%m-%d}",
                                                       grouped(fit.points), scans.size(), fmt::gmtime(now)));
  writeFile(out, yaml);
  printText(
      "\n{}\nwrote {}: use it as `preset:` of a sensor; `scanmill fit-noise --sensor` takes it to measure the noise\n",
      yaml, out.string());
  return 0;
}

}  // namespace scanmill
