#include "study/repeatability/repeatability.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/error.h"
#include "base/file.h"
#include "base/parallel.h"
#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/stop_signal.h"
#include "commands/table.h"
#include "pipeline/plan/plan.h"
#include "pipeline/scenes/shot_source.h"
#include "report/page/page.h"
#include "report/repeatability/repeatability_report.h"
#include "study/figure_text.h"
#include "study/repeatability/repeatability_choice.h"

namespace scanmill {

namespace {

constexpr const char* kResultFile = "repeatability.json";

// Formats a fitness (m²) in cm², with the decimals that show `like` with three significant digits.
std::string squareCentimetres(double fitness, double like) {
  constexpr double kSquareCentimetres = 1e4;  // square centimetres per square metre
  constexpr int kMostDecimals = 4;            // largest number of decimals; further decimals are rounding errors
  const double size = std::log10(std::max(like * kSquareCentimetres, 1e-9));
  return fmt::format("{:.{}f}", fitness * kSquareCentimetres,
                     std::clamp(2 - static_cast<int>(std::floor(size)), 0, kMostDecimals));
}

std::string fitnessText(const FitnessSpread& spread) {
  if (spread.count == 0) return "-";
  if (!hasDeviation(spread)) return squareCentimetres(spread.mean, spread.mean);
  return fmt::format("{} +- {}", squareCentimetres(spread.mean, spread.mean),
                     squareCentimetres(spread.deviation, spread.mean));
}

void printResult(const Repeatability& result, const std::string& date) {
  printText("{}, seen by {}; {}\n", fmt::join(result.objects(), ", "), fmt::join(result.sensors(), ", "), date);
  printText(
      "ICP fitness (mean squared distance) in cm2 (1e-4 m2), mean +- standard deviation; noise {}, {} scans of each "
      "pose\n\n",
      result.levels[result.reference], result.scans);
  Rows rows{{"view", "object", "frame", "m", "points", "after ICP", "without ICP"}};
  const bool several = result.methods.size() > 1;
  if (several) rows.front().insert(rows.front().begin(), "method");
  for (const RepeatedView& view : result.views) {
    for (const RepeatedPlace& place : view.places) {
      const LevelFitness& cell = result.at(place, result.reference, result.reference);
      rows.push_back({view.name, place.object, std::to_string(place.frame), fmt::format("{:.4g}", place.distance),
                      fmt::format("{:.1f}", place.points[result.reference].mean), fitnessText(cell.registered),
                      fitnessText(cell.unmoved)});
      if (several) rows.back().insert(rows.back().begin(), result.methods[view.method]);
    }
  }
  printText("{}\n", formatTable(rows));
}

// Writes the report's files, kResultFile last: if this file exists, the report is complete.
void writeResult(const Repeatability& result, const std::string& date, const std::filesystem::path& folder) {
  std::vector<Chart> charts = repeatabilityCharts(result, 0);
  if (result.levels.size() > 1) {
    for (Chart& chart : repeatabilityViewCharts(result, result.views.front())) charts.push_back(std::move(chart));
  }
  for (const Chart& chart : charts) writeFile(folder / (chart.name + ".svg"), drawSvg(chart));
  writeFile(folder / "index.html", repeatabilityReport(result, date));
  writeFile(folder / kResultFile, repeatabilityJson(result));
}

}  // namespace

int runRepeatability(const std::vector<std::string>& arguments) {
  CommandOptions options("repeatability");
  cxxopts::OptionAdder add = options.add_options();
  add("o,out", "folder of the report; it is made if it does not exist", textValue(), "DIR");
  add("overwrite", "replace an existing report");
  add("q,quiet", "print one line instead of progress and tables");
  addPipelineOptions(options);
  const Arguments parsed =
      parseArguments(options, arguments,
                     "  scanmill repeatability pipelines/paper/repeatability.yaml -o out/repeatability\n"
                     "  scanmill repeatability pipelines/paper/repeatability.yaml -o out/methods "
                     "--set 'repeatability.methods=[ray_tracing, {depth_camera: {resolution: 512}}]'\n"
                     "  scanmill repeatability pipelines/street.yaml -o out/nearest --set trajectories.0.frames=3\n");
  if (parsed.help) return 0;
  parsed.positional("PIPELINE");  // report a missing pipeline before all else
  const std::filesystem::path folder = folderOption(parsed, "out");
  if (folder.empty()) throw InputError("-o DIR is missing: where should the report go?");
  const ResourceLimits limits(parsed);
  Pipeline pipeline = readPipeline(parsed.pipeline(), pipelineOverrides(parsed));
  const Channels channels = repeatabilityChannels(pipeline);
  const Plan plan = makePlan(std::move(pipeline), channels);
  const ShotSource vehicle(plan);  // a vehicle that cannot be used is refused before the folder is made
  prepareReportFolder(folder, kResultFile, parsed.has("overwrite"));
  const RepeatabilityOptions run{.quiet = parsed.has("quiet"), .stop = &stopSignal()};
  const Repeatability result = measureRepeatability(plan, run);
  const std::string date = today();
  writeResult(result, date, folder);
  for (const std::string& warning : result.warnings) warn(warning);
  if (!run.quiet) printResult(result, date);
  std::size_t poses = 0;
  for (const RepeatedView& view : result.views) poses += view.places.size();
  printText("{} {}, {} noise {}: open {}\n", grouped(poses), poses == 1 ? "pose" : "poses", result.levels.size(),
            result.levels.size() == 1 ? "level" : "levels", (folder / "index.html").string());
  return 0;
}

}  // namespace scanmill
