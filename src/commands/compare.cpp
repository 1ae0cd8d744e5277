#include "study/compare/compare.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "base/error.h"
#include "base/file.h"
#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/stop_signal.h"
#include "commands/table.h"
#include "report/compare/compare_report.h"
#include "report/page/page.h"
#include "study/figure_text.h"

namespace scanmill {

namespace {

constexpr const char* kComparisonFile = "compare.json";
constexpr const char* kPageFile = "index.html";
constexpr std::size_t kMostScans = 200;  // greatest number of scans per set; each takes about 2 MB of memory

// Prints how the sensors stand, features of patches, figures of the sets, how many surfaces are alike, and settings to
// try. Rows that only another scene changes stand below those that a setting changes.
void printComparison(const SetComparison& comparison) {
  const RoadPoses &real = comparison.real.roadPose, &simulated = comparison.simulated.roadPose;
  const auto spreadText = [](const FigureSpread& s) {
    return std::isnan(s.median) ? "-" : fmt::format("{:.2f} ({:.2f} to {:.2f})", s.median, s.low, s.high);
  };
  Rows rows{{"how the sensor stands: median (16 to 84 %)", "", "real", "simulated", "simulated against real"}};
  for (std::size_t f = 0; f < kRoadFigureCount; ++f) {
    rows.push_back({std::string(kRoadFigures[f].title), std::string(kRoadFigures[f].unit), spreadText(real[f]),
                    spreadText(simulated[f]), differenceText(f, real, simulated)});
  }
  printText("{}\n", formatTable(rows));
  for (const bool isOfScene : {false, true}) {
    rows = {{isOfScene ? "feature that only the scene moves" : "feature of a patch", "separation", "within real",
             "real", "simulated", "changed by"}};
    for (const Separation& s : comparison.features) {
      const ComparedFigure& f = kPatchFeatures[s.feature];
      const double withinReal = comparison.withinReal[s.feature];
      if (f.isOfScene != isOfScene) continue;
      rows.push_back({std::string(f.title), fmt::format("{:.3f}", s.strength),
                      std::isnan(withinReal) ? "-" : fmt::format("{:.3f}", withinReal),
                      figureText(s.realValue, f.factor, f.unit), figureText(s.simulatedValue, f.factor, f.unit),
                      std::string(f.keys)});
    }
    printText("{}\n", formatTable(rows));
  }
  printText(
      "separation: |area under the ROC curve - 0.5| of the real against the simulated patches, 0 to 0.5; within real:\n"
      "the same of odd against even real scans\n\n");
  for (const bool isOfScene : {false, true}) {
    rows = {{isOfScene ? "figure that only the scene moves" : "figure", "real", "simulated", "changed by"}};
    for (std::size_t i = 0; i < kSetFigureCount; ++i) {
      const ComparedFigure& f = kSetFigures[i];
      if (f.isOfScene != isOfScene) continue;
      rows.push_back({std::string(f.title), figureText(comparison.real.figures[i], f.factor, f.unit),
                      figureText(comparison.simulated.figures[i], f.factor, f.unit), std::string(f.keys)});
    }
    printText("{}\n", formatTable(rows));
  }
  const auto [alike, all] = comparison.surfacesAlike();
  printText(
      "{} of {} figures of surfaces in the small (by {} and range, on the page) are within a factor of {} of the "
      "real ones\n\n",
      alike, all, comparison.byClass ? "class" : "shape", kAlike);
  if (comparison.advice.empty()) return printText("settings to try: none. {}\n\n", comparison.unadvised);
  rows = {{"to try", "now", "try", "for"}};
  for (const KeyChange& a : comparison.advice) {
    rows.push_back({a.key, fmt::format("{:g}", a.current), nextText(a), std::string(a.figure.title)});
  }
  printText("{}to change all at once, add to the options that made the set: --set '{}'\n\n", formatTable(rows),
            fmt::join(comparison.assignments, "' --set '"));
}

}  // namespace

int runCompare(const std::vector<std::string>& arguments) {
  CommandOptions options("compare");
  options.add("o,out", "folder of the page and the figures; it is made if it does not exist", textValue(), "DIR");
  options.add("scans", "the greatest number of scans to read of each set, evenly spaced",
              cxxopts::value<std::size_t>()->default_value("20"), "N");
  options.add("sensor", "the sensor to compare, if a dataset has several (default: the first)", textValue(), "NAME");
  options.add("pipeline",
              "the pipeline that made SIMULATED, for the settings to try (default: searched for near the dataset)",
              textValue(), "FILE");
  options.add("overwrite", "replace an existing comparison");
  addThreads(options);
  options.add("q,quiet", "print one line instead of progress and tables");
  addInputLimit(options);
  const Arguments parsed =
      parseArguments(options, arguments,
                     "  scanmill compare SemanticKITTI/sequences/08 out/training -o out/compared\n"
                     "  scanmill compare recorded_frames/ out/street -o out/compared --scans 50 --overwrite\n");
  const std::vector<std::string> sets = parsed.inputs();
  if (sets.size() != 2) {
    throw InputError(
        fmt::format("compare takes two sets, REAL and SIMULATED, not {}: each is a folder of recorded scans (single "
                    "files, SemanticKITTI, KITTI or nuScenes), a dataset, a shard or a scan",
                    sets.size()));
  }
  const std::filesystem::path folder = folderOption(parsed, "out");
  if (folder.empty()) throw InputError("-o DIR is missing: where should the page go?");
  ScanSetOptions setOptions;
  setOptions.scans = parsed.options["scans"].as<std::size_t>();
  if (setOptions.scans < 1 || setOptions.scans > kMostScans) {
    throw InputError(fmt::format("--scans must be from 1 to {}, not {}", kMostScans, setOptions.scans));
  }
  setOptions.sensor = parsed.text("sensor");
  setOptions.stop = &stopSignal();
  prepareReportFolder(folder, kComparisonFile, parsed.has("overwrite"));

  Progress progress("compare", 2 * setOptions.scans, "scans", "points", parsed.has("quiet"));
  ScanSet real = readScanSet(sets[0], setOptions, progress);
  progress.setTotal(real.scans + setOptions.scans);
  ScanSet simulated = readScanSet(sets[1], setOptions, progress);
  if (!setOptions.sensor.empty() && !real.foundSensor && !simulated.foundSensor) {
    throw InputError(fmt::format("--sensor {}: neither set has a sensor of this name", setOptions.sensor));
  }
  progress.say("comparing the sets");
  SetComparison comparison = compareSets(std::move(real), std::move(simulated));
  addKeyChanges(comparison, sets[1], setOptions.sensor, parsed.text("pipeline"));
  if (*setOptions.stop) throw Error("stopped: nothing was written");

  const std::string date = today();
  beginReport(folder, kComparisonFile);
  writeFile(folder / kPageFile, comparisonPage(comparison, date));
  writeFile(folder / kComparisonFile, comparisonJson(comparison, date));
  for (const std::string& warning : comparison.warnings) warn(warning);
  if (comparison.features.empty()) {
    warn("the sets have no patches of the same class or shape at similar ranges, so their patches are not compared");
  }
  if (!parsed.has("quiet")) printComparison(comparison);
  printText("compared {} points of {} with {} of {}: open {}\n", grouped(comparison.real.points), comparison.real.name,
            grouped(comparison.simulated.points), comparison.simulated.name, (folder / kPageFile).string());
  return 0;
}

}  // namespace scanmill
