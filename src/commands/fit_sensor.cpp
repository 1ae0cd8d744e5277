#include "study/sensor/fit_sensor.h"

#include <fmt/core.h>

#include <cmath>
#include <filesystem>

#include "base/file.h"
#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/command.h"
#include "commands/recorded_scans.h"
#include "study/compare/road_pose.h"
#include "study/figure_text.h"

namespace scanmill {

namespace {

// Prints how the sensor stands over its ground, and the mount for a pipeline, if the scans show the ground.
void printMount(const std::vector<Scan>& scans) {
  PosesBySequence poses;
  for (const Scan& scan : scans) poses[""].push_back(roadPoseOf(scan, nullptr));
  const RoadPoses spreads = spreadsOf(poses);
  if (std::isnan(spreads[kHeight].median) || std::isnan(spreads[kLaneSlope].median)) return;
  printText(
      "{0:.2f} m above the ground within 12 m, looking {1:.2f} deg down on it; the left side is raised by {2:.2f} deg "
      "over the own lane:\nin a pipeline, mount: {{position: [0, 0, {0:.2f}], pitch_deg: {1:.2f}, roll_deg: "
      "{2:.2f}}}\n",
      spreads[kHeight].median, spreads[kPitch].median, -spreads[kLaneSlope].median);
}

}  // namespace

int runFitSensor(const std::vector<std::string>& arguments) {
  CommandOptions options("fit-sensor");
  options.add("o,out", "the sensor file to write", textValue(), "FILE");
  options.add("overwrite", "replace the file");
  addSimulatedOption(options);
  const Arguments parsed = parseArguments(
      options, arguments,
      "  scanmill fit-sensor frames/*.pcd -o my_sensor.yaml\n"
      "The scans must be organised or have the columns ring and column; their points must be in the sensor's frame.\n");
  if (!parsed.has("input")) throw InputError("SCAN is missing; see --help");
  const std::filesystem::path out = requiredFile(parsed, "name the sensor file to write, such as my_sensor.yaml");
  std::vector<Scan> scans;
  forEachScan(parsed.inputs(), [&](const Scan& scan, const std::string&) { scans.push_back(scan); });
  const SensorFit fit = fitSensor(scans);

  printText("fitted to {} points of {} scans: {} rings x {} columns over {}\n", grouped(fit.points), scans.size(),
            fit.rings, fit.columns,
            fit.field > 2 * kPi - 1e-9 ? std::string("a full turn") : fmt::format("{:.2f} deg", degrees(fit.field)));
  printText("half of the points lie within {:.4f} deg of their ring's elevation and {:.4f} deg of its azimuth\n",
            degrees(fit.elevationSpread), degrees(fit.azimuthSpread));
  constexpr double kOff = 0.1;  // degrees, largest spread that can come from a sensor's errors
  if (degrees(std::max(fit.elevationSpread, fit.azimuthSpread)) > kOff) {
    warn(
        "this is more than the errors of a sensor: the points must be in the sensor's frame, not the vehicle's, and "
        "not deskewed");
  }
  if (!fit.bareRings.empty()) {
    warn(
        "{} rings (the first is {}) have too few points, so their elevations are interpolated between "
        "other rings: name more scans",
        fit.bareRings.size(), fit.bareRings.front());
  }
  printMount(scans);
  std::string yaml =
      sensorYaml(fit, fmt::format("fitted to {} points of {} scans, {}", grouped(fit.points), scans.size(), today()));
  if (const auto response = responseOf(scans, parsed)) yaml += "effects:\n" + response->yaml;
  writeFile(out, yaml);
  printText(
      "\n{}\nwrote {}: use it as `preset:` of a sensor; `scanmill fit-noise --sensor` takes it to measure the noise\n",
      yaml, out.string());
  return 0;
}

}  // namespace scanmill
