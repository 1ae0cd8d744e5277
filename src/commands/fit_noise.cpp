#include "study/noise/fit_noise.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <functional>

#include "base/error.h"
#include "base/file.h"
#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/recorded_scans.h"
#include "commands/stop_signal.h"
#include "commands/table.h"
#include "config/fields.h"
#include "config/resources.h"
#include "config/value.h"
#include "sensors/sensor.h"
#include "study/figure_text.h"

namespace scanmill {

namespace {

// Prints a row for each band of ranges. Figures that were not measured are "-".
void printBands(const std::vector<PatchGroup>& bands) {
  Rows rows{{fmt::format("range (incidence to {:g} deg)", kMostIncidenceDegrees), "patches", "points", "sigma mm", "+-",
             "with step", "about planes", "lost", "of", "drop-out %", "+-", ""}};
  for (const PatchGroup& g : bands) {
    const auto figure = [](bool measured, double value) {
      return measured ? fmt::format("{:.2f}", value) : std::string("-");
    };
    const auto millimetres = [&](double metres) { return figure(g.patches > 0, 1000 * metres); };
    const bool hasDropOut = g.dropOut.beams > 0;
    rows.push_back({g.name, grouped(g.patches), grouped(g.points), millimetres(g.sigma), millimetres(g.error),
                    millimetres(g.withStep), millimetres(g.planeSigma), grouped(g.dropOut.lost),
                    grouped(g.dropOut.beams), figure(hasDropOut, 100 * g.dropOut.share()),
                    figure(hasDropOut, 100 * g.dropOut.error), g.leftOut.empty() ? "" : "left out: " + g.leftOut});
  }
  printText("{}\n", formatTable(rows));
}

// Prints the rotation and shift of the frame of a scan's points relative to the sensor's frame, unless both are equal.
void printFrame(const RecordedScan& scan) {
  constexpr double kNoDifference = 1e-4;  // rad and m; chosen by eye
  const Pose& pose = scan.scanFromSensor;
  const double angle = 2 * std::acos(std::min(1.0, std::abs(pose.rotation.w)));
  if (angle < kNoDifference && length(pose.translation) < kNoDifference) return;
  printText(
      "{}: the frame of its points is rotated by {:.2f} deg and shifted by [{:.4f}, {:.4f}, {:.4f}] m from the "
      "sensor's\n",
      scan.name, degrees(angle), pose.translation.x, pose.translation.y, pose.translation.z);
}

// Measures, prints and returns the noise of the scans. `checkStop` throws an Error if the user has stopped the program.
NoiseFit measureNoise(const BeamTable& beams, const std::vector<Scan>& scans, const std::vector<std::string>& names,
                      const std::function<void()>& checkStop) {
  std::vector<RecordedScan> recorded;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    recorded.push_back(rangesAlong(scans[i], beams, names[i]));
    recorded.back().name = std::filesystem::path(names[i]).filename().string();
    printFrame(recorded.back());
    checkStop();
  }
  const std::vector<FlatPatch> patches = findFlatPatches(beams, recorded);
  checkStop();
  NoiseFit fit = fitNoise(beams, recorded, patches);
  checkStop();

  printText("{} of {} beams returned ({}); range step: {}\n\n", grouped(fit.returns), grouped(fit.beams),
            percent(fit.returns, fit.beams), fit.step > 0 ? fmt::format("{:.3g} mm", fit.step * 1000) : "none found");
  printBands(fit.bands);
  printText(
      "sigma:        standard deviation of the range about a smooth surface, without the rounding to the range step\n"
      "with step:    the same with the rounding, as the recording has it\n"
      "about planes: standard deviation about a flat plane, with offsets between rings, curvature and vehicle motion\n"
      "lost, of:     beams without a return, and all beams whose neighbours returned from the plane of a patch\n\n");

  const auto printRings = [](const char* what, const RingSpread& spread, const std::string& sigma) {
    if (spread.rings == 0) return;
    printText(
        "{} of {} rings have a standard deviation of {}; odd and even patches agree with a correlation of {:.2f}{}\n",
        what, spread.rings, sigma, spread.agreement,
        spread.agreement < kOwnErrors ? ": too little, so they count as noise and are left out" : "");
  };
  printRings("offsets of the range", fit.rings.range, fmt::format("{:.1f} mm", 1000 * fit.rings.range.sigma));
  printRings("errors of the elevation", fit.rings.elevation,
             fmt::format("{:.3f} deg", degrees(fit.rings.elevation.sigma)));
  if (fit.rings.elevation.rings == 0)
    printText("errors of elevation count as offsets: both walls and level ground tell them apart\n");
  printRings("gains", fit.rings.gain, fmt::format("{:.1f} %", 100 * fit.rings.gain.sigma));
  printText("\n");
  return fit;
}

}  // namespace

int runFitNoise(const std::vector<std::string>& arguments) {
  CommandOptions options("fit-noise");
  options.add("sensor", "the sensor that recorded the scans: a sensor file, or a name of `scanmill list sensors`",
              textValue(), "FILE|NAME");
  options.add("o,out", "the sensor file to write, with the fitted effects; pipelines use them by `effects: sensor`",
              textValue(), "FILE");
  options.add("overwrite", "replace the file");
  addSimulatedOption(options);
  addThreads(options);
  addInputLimit(options);
  const Arguments parsed =
      parseArguments(options, arguments,
                     "  scanmill fit-noise frames/*.pcd --sensor os1_128 -o my_os1.yaml\n"
                     "  scanmill fit-noise frames/*.pcd --sensor my.yaml -o my_fitted.yaml --overwrite\n"
                     "  scanmill fit-noise frames/*.pcd --sensor my.yaml -o my_fitted.yaml --simulated out/towns\n");

  if (!parsed.has("input")) throw InputError("SCAN is missing; see --help");
  const std::filesystem::path preset = namedResource(
      requiredText(parsed, "sensor", "name the sensor that recorded the scans, such as os1_128"), "pipelines/sensors");
  const std::filesystem::path out = requiredFile(parsed, "name the sensor file to write, such as fitted.yaml");
  const std::atomic<bool>& stop = stopSignal();
  const auto checkStop = [&] {
    if (stop) throw Error("stopped: nothing was written");
  };

  const std::string text = readFile(preset);
  const Value sensor = parseYaml(text, preset.string());
  expectKind(sensor, FileKind::Sensor);
  const auto beams = makeBeams(sensor);
  withEffects(text, preset.string(), "effects: []\n");  // throws early if the file cannot take effects
  std::vector<Scan> scans;
  std::vector<std::string> names;
  forEachScan(parsed.inputs(), [&](const Scan& scan, const std::string& name) {
    scans.push_back(scan);
    names.push_back(name);
    checkStop();
  });
  const std::optional<FoundResponse> response = responseOf(scans, parsed);
  checkStop();
  std::string effects = "effects:\n" + (response ? response->yaml : "");
  std::vector<std::string> warnings;
  try {
    NoiseFit fit = measureNoise(*beams, scans, names, checkStop);
    if (response && response->fit.slope > 0) fit.rings.gain.sigma /= response->fit.slope;
    effects += effectsYaml(fit, today());
    warnings = beyondMeasured(fit);
  } catch (const InputError& e) {
    if (!response) throw;
    warn("only the response was found, not the noise: {}", e.what());
  }
  printText("{}", effects);
  const std::string fitted = withEffects(text, preset.string(), effects);
  if (!warnings.empty()) warn("{}", fmt::join(warnings, " "));
  writeFile(out, fitted);
  const Value made = parseYaml(fitted, out.string());
  const bool hasIntensity = std::ranges::any_of(
      made.find("effects")->items, [](const Value& item) { return readNamed(item, "an effect").name == "intensity"; });
  printText("\nwrote {}: use it as `preset:` of a sensor, with `effects: {}` in the pipeline\n", out.string(),
            hasIntensity ? "sensor" : "[sensor, intensity]");
  return 0;
}

}  // namespace scanmill
