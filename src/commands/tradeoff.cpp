#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/error.h"
#include "base/file.h"
#include "base/short_text.h"
#include "base/terminal.h"
#include "commands/arguments.h"
#include "commands/stop_signal.h"
#include "commands/table.h"
#include "pipeline/plan/plan.h"
#include "pipeline/scenes/shot_source.h"
#include "report/page/page.h"
#include "report/tradeoff/report.h"
#include "study/figure_text.h"
#include "study/tradeoff/study.h"

namespace scanmill {

namespace {

constexpr const char* kStudyFile = "tradeoff.json";

void printSettings(const Study& study) {
  Rows rows{{"setting", "set-up", "scan", "beams/s", "memory", "median", "p99", "away from edges", "labels",
             "false negatives", "false positives", "to", "from"}};
  for (const SettingResult& s : study.settings) {
    if (!s.failure.empty()) {
      rows.push_back({s.setting.name, "failed", "", "", "", "", "", "", "", "", "", "", ""});
      continue;
    }
    const Cost& cost = s.measured.cost;
    const GroupErrors& e = s.measured.errors.all;  // errors of all beams
    const GroupErrors* const awayErrors = errorsNamed(s.measured.errors.byEdge, kAwayFromEdges);
    const auto beams = static_cast<double>(e.beams);
    rows.push_back({s.setting.name, secondsText(cost.setupSeconds), secondsText(cost.scanSeconds),
                    shortNumber(beamsPerSecond(study, s)), shortBytes(cost.memoryBytes), metresText(e.range.median),
                    metresText(e.range.p99), awayErrors == nullptr ? "" : metresText(awayErrors->range.p99),
                    fmt::format("{:.3f} %", 100 * e.labels()),
                    fmt::format("{:.3f} %", 100 * static_cast<double>(e.falseNegatives) / beams),
                    fmt::format("{:.3f} %", 100 * static_cast<double>(e.falsePositives) / beams),
                    metresText(e.nearestTo.mean), metresText(e.nearestFrom.mean)});
  }
  printText(
      "{}median, p99: of the range error; away from edges: p99 there; false negatives: beams that hit only in truth;\n"
      "false positives: beams that hit only by the setting; to: mean distance from points of the truth to the nearest\n"
      "of the setting; from: mean distance from points of the setting to the nearest of the truth\n\n",
      formatTable(rows));
  for (const SettingResult& s : study.settings) {
    if (!s.failure.empty()) printText("{} failed: {}\n", s.setting.name, s.failure);
  }
}

void printStudy(const Study& study) {
  printText("{}: {} of {} beams, {} triangles; {}, {}{}{}\n\n", study.scene.key, pluralOf(study.shots, "scan"),
            grouped(study.beamsPerShot), grouped(study.scene.triangles), study.machine.processor,
            pluralOf(static_cast<std::uint64_t>(study.machine.threads), "thread"),
            study.machine.renderer.empty() ? "" : "; OpenGL: ", study.machine.renderer);
  printSettings(study);
  for (const std::string& line : study.leftOut) printText("left out: {}\n", line);
  for (const Advice& a : advise(study)) {
    printText("{}: {}\n", a.need, a.setting.empty() ? a.text : fmt::format("{}\n  {}", a.setting, a.text));
  }
}

// Writes the report's files, kStudyFile last: if this file exists, the report is complete. The page contains all
// charts. The chart "pareto", and the other charts in kStudyFiles if they show points, are also written as SVG files.
void writeStudy(const Study& study, const std::filesystem::path& folder) {
  beginReport(folder, kStudyFile);
  for (std::size_t i = 0; i < study.pictures.size(); ++i) {
    writeFile(folder / fmt::format("errors-{}.png", i + 1), study.pictures[i].png);
  }
  for (const Chart& chart : studyCharts(study)) {
    const bool isListed = std::ranges::find(kStudyFiles, chart.name) != kStudyFiles.end();
    if (!isListed || !(hasPoints(chart) || chart.name == "pareto")) continue;
    writeFile(folder / (chart.name + ".svg"), drawSvg(chart));
  }
  writeFile(folder / "index.html", studyReport(study, folder.string()));
  writeFile(folder / kStudyFile, toJson(study));
}

}  // namespace

int runTradeoff(const std::vector<std::string>& arguments) {
  CommandOptions options("tradeoff");
  options.add("o,out", "folder of the report; it is made if it does not exist", textValue(), "DIR");
  options.add("overwrite", "replace an existing report");
  options.add("budget", "about how many minutes the study may take (default: 5)", textValue(), "MINUTES");
  options.add("q,quiet", "print one line instead of progress and tables");
  addPipelineOptions(options);
  const Arguments parsed =
      parseArguments(options, arguments,
                     "  scanmill tradeoff pipelines/street.yaml -o out/tradeoff\n"
                     "  scanmill tradeoff pipelines/street.yaml -o out/longer --budget 30\n"
                     "  scanmill tradeoff pipelines/street.yaml -o out/few --set 'tradeoff={settings: [ray_tracing, "
                     "{particle: {voxel_m: [0.05, 0.1, 0.2], refine: none}}]}'\n");
  parsed.positional("PIPELINE");  // report a missing pipeline before all else
  const std::string folder = folderOption(parsed, "out");
  if (folder.empty()) throw InputError("-o DIR is missing: where should the report go?");
  StudyOptions studyOptions{.quiet = parsed.has("quiet"), .stop = &stopSignal(), .drawErrors = drawErrors};
  if (parsed.has("budget")) {
    constexpr double kMostMinutes = 1e5;
    const double minutes = parsed.number("budget", -INFINITY, INFINITY);
    if (!(minutes > 0 && minutes <= kMostMinutes)) {
      throw InputError(fmt::format("--budget must be above 0 and at most {} minutes, not {}", kMostMinutes, minutes));
    }
    studyOptions.budgetSeconds = 60 * minutes;
  }
  const Plan plan = makePlan(readPipeline(parsed.pipeline(), pipelineOverrides(parsed)));
  readStudyChoice(plan.pipeline);
  const ShotSource vehicle(plan);  // a vehicle that cannot be used is refused before the folder is made
  prepareReportFolder(folder, kStudyFile, parsed.has("overwrite"));
  const Study study = runStudy(plan, studyOptions);
  writeStudy(study, folder);
  if (!studyOptions.quiet) printStudy(study);
  printText("{} in {}: open {}\n", pluralOf(study.settings.size(), "setting"), shortTime(study.seconds),
            (std::filesystem::path(folder) / "index.html").string());
  return 0;
}

}  // namespace scanmill
