// Writes tradeoff.csv for spreadsheets and notebooks, with one row per setting and group of beams.

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <string_view>

#include "study/tradeoff/study.h"

namespace scanmill {

namespace {

constexpr std::string_view kHeader =
    "setting,method,options,setup_s,scan_s,beams_per_s,stages_s,memory_bytes,nearest_to_mean_m,nearest_from_mean_m,"
    "hausdorff_m,group_kind,group,low,high,beams,both_hit,both_miss,false_negatives,false_positives,unresolved,"
    "class_agreed,instance_agreed,labels,range_mean_m,range_rms_m,range_median_m,range_p95_m,range_p99_m,range_p999_m,"
    "range_max_m,intensity_mean_error,group_nearest_to_mean_m,group_nearest_from_mean_m,group_hausdorff_m,failure";
constexpr std::size_t kCells = 1 + static_cast<std::size_t>(std::ranges::count(kHeader, ','));

// Quotes a cell as RFC 4180 requires.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string number(double value) {
  return std::isfinite(value) ? fmt::format("{:.9g}", value) : std::string();
}

std::string spreadCells(const Spread& s) {
  if (s.count == 0) return ",,,,,,";
  return fmt::format("{},{},{},{},{},{},{}", number(s.mean), number(s.rms), number(s.median), number(s.p95),
                     number(s.p99), number(s.p999), number(s.max));
}

std::string meanCell(const Spread& s) {
  return s.count == 0 ? std::string() : number(s.mean);
}

// Returns the times of stages (s per scan, as the method reports them), such as "render=0.0063;read_back=0.0027".
std::string stagesCell(const std::map<std::string, double>& stages) {
  std::string text;
  for (const auto& [stage, seconds] : stages) {
    text += fmt::format("{}{}={}", text.empty() ? "" : ";", stage, number(seconds));
  }
  return cell(text);
}

// Returns the cells with a setting's cost and its distances between clouds, which are the same in all rows of the
// setting.
std::string settingCells(const Study& study, const SettingResult& result) {
  const Cost& cost = result.measured.cost;
  const CloudErrors& cloud = result.measured.cloud;
  return fmt::format("{},{},{},{},{},{},{},{},{},{},{}", cell(result.setting.name), cell(result.setting.method),
                     cell(result.setting.options), number(cost.setupSeconds), number(cost.scanSeconds),
                     number(cost.beamsPerSecond(study.beamsPerShot)), stagesCell(cost.stages), cost.memoryBytes,
                     number(cloud.to.mean), number(cloud.from.mean), number(cloud.hausdorff));
}

std::string groupCells(const std::string& kind, const ErrorGroup& group) {
  const GroupErrors& e = group.errors;
  const bool near = e.nearestTo.count + e.nearestFrom.count > 0;
  const std::string hausdorff = near ? number(e.hausdorff()) : std::string();
  return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}", kind, cell(group.name), number(group.low),
                     number(group.high), e.beams, e.bothHit, e.bothMiss, e.falseNegatives, e.falsePositives,
                     e.unresolved, number(e.classAgreed()), number(e.instanceAgreed()), number(e.labels()),
                     spreadCells(e.range), meanCell(e.intensity), meanCell(e.nearestTo), meanCell(e.nearestFrom),
                     hausdorff);
}

}  // namespace

std::string toCsv(const Study& study) {
  std::string csv = std::string(kHeader) + "\n";
  for (const SettingResult& result : study.settings) {
    if (!result.failure.empty()) {
      const Setting& s = result.setting;
      csv += fmt::format("{},{},{}{}{}\n", cell(s.name), cell(s.method), cell(s.options), std::string(kCells - 3, ','),
                         cell(result.failure));
      continue;
    }
    const std::string setting = settingCells(study, result);
    const auto add = [&](const std::string& kind, const ErrorGroup& group) {
      csv += fmt::format("{},{},\n", setting, groupCells(kind, group));
    };
    const BeamErrors& e = result.measured.errors;
    add("all", {"all", 0, INFINITY, e.all});
    for (const ErrorGroup& group : e.byRange) add("range_m", group);
    for (const ErrorGroup& group : e.byIncidence) add("incidence_deg", group);
    for (const ErrorGroup& group : e.byPlace) add("place", group);
    for (const ErrorGroup& group : e.byClass) add("class", group);
  }
  return csv;
}

}  // namespace scanmill
