#include "report/tradeoff/report_tables.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "base/short_text.h"
#include "report/page/report_html.h"
#include "report/tradeoff/report_charts.h"
#include "report/tradeoff/report_figures.h"
#include "study/figure_text.h"
#include "study/tradeoff/study_figures.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostColumns = 6;
constexpr const char* kNearestHint = "mean distance from each true point to the nearest of the setting's";
constexpr const char* kFalseNegativeHint = "only the truth hits";
constexpr const char* kFalsePositiveHint = "only the setting hits";
constexpr const char* kHausdorffHint = "the largest distance of either direction";

HtmlCell metresCell(double metres) {
  return {metresText(metres), metres};
}
HtmlCell secondsCell(double seconds) {
  return {secondsText(seconds), seconds};
}
HtmlCell shareCell(double share) {
  return {shareText(share), share};
}
HtmlCell amountCell(double amount) {
  return {amountText(amount), amount};
}
HtmlCell countCell(std::uint64_t count) {
  return amountCell(static_cast<double>(count));
}

// Of the beams, with their number.
HtmlCell beamsCell(std::uint64_t part, std::uint64_t whole) {
  const double share = whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
  return {shareText(share), share, fmt::format("{} of {} beams", part, whole)};
}

// From true points to the nearest of the setting's, on average.
HtmlCell nearestCell(const GroupErrors& e) {
  if (e.nearestTo.count == 0) return {};
  const std::string back = e.nearestFrom.count > 0 ? metresText(e.nearestFrom.mean) : "no points";
  return {metresText(e.nearestTo.mean), e.nearestTo.mean,
          fmt::format("back: {}; Hausdorff {}", back, metresText(e.hausdorff()))};
}

HtmlCell hausdorffCell(const GroupErrors& e) {
  return e.nearestTo.count + e.nearestFrom.count > 0 ? metresCell(e.hausdorff()) : HtmlCell{};
}

// What a stage takes a scan, and how many beams go through it.
void addStage(std::vector<HtmlCell>& cells, const Study& study, const std::map<std::string, double>& stages,
              const std::string& stage) {
  const auto found = stages.find(stage);
  if (found == stages.end() || found->second <= 0) {
    cells.insert(cells.end(), 2, HtmlCell{});
    return;
  }
  cells.push_back(secondsCell(found->second));
  cells.push_back(amountCell(static_cast<double>(study.beamsPerShot) / found->second));
}

// Of one method's settings among `rows`: other methods have other stages.
std::string stagesTable(const Study& study, const std::string& method, const std::vector<std::size_t>& rows) {
  std::vector<std::size_t> own;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(own),
               [&](std::size_t i) { return study.settings[i].setting.method == method; });
  std::vector<std::string> stages;
  for (const std::size_t i : own) {
    for (const auto& [stage, seconds] : study.settings[i].measured.cost.stages) {
      const bool known = std::find(stages.begin(), stages.end(), stage) != stages.end();
      if (seconds > 0 && !known) stages.push_back(stage);
    }
  }
  HtmlTable table;
  table.group("", 2);
  table.column("setting");
  table.column("set-up", "making the method and preparing it for the first scan");
  const auto pair = [&](const std::string& title, const char* hint) {
    table.group(title, 2);
    table.column("a scan", hint);
    table.column("beams/s", hint);
  };
  pair("tracing, in all", "median of wall-clock time, all threads together");
  for (const std::string& stage : stages) pair(wordsOf(stage), "summed over the threads that work on it");
  for (const auto& entry : study.commonStages) pair(entry.first + ", one thread", "the same whatever the setting");
  for (const std::size_t i : own) {
    const SettingResult& s = study.settings[i];
    const Cost& cost = s.measured.cost;
    std::vector<HtmlCell> cells{{s.setting.name}, secondsCell(cost.setupSeconds)};
    addStage(cells, study, {{"trace", cost.scanSeconds}}, "trace");
    for (const std::string& stage : stages) addStage(cells, study, cost.stages, stage);
    for (const auto& entry : study.commonStages) addStage(cells, study, study.commonStages, entry.first);
    table.row(std::move(cells));
  }
  return table.empty() ? "" : table.html();
}

bool isIn(const std::vector<std::size_t>& list, std::size_t i) {
  return std::find(list.begin(), list.end(), i) != list.end();
}

void settingRow(HtmlTable& table, const Study& study, std::size_t i, bool front) {
  const SettingResult& s = study.settings[i];
  const Cost& cost = s.measured.cost;
  const GroupErrors& e = s.measured.errors.all;
  const CloudErrors& cloud = s.measured.cloud;
  const std::optional<std::size_t> base = tracingDefault(study);
  HtmlCell ratio{"", std::nan("")};
  if (base && cost.scanSeconds > 0 && study.settings[*base].measured.cost.scanSeconds > 0) {
    const double times = cost.scanSeconds / study.settings[*base].measured.cost.scanSeconds;
    ratio = {factorText(times), times};
  }
  std::string hint = setArgument(s.setting);
  for (const std::string& warning : s.measured.warnings) hint += "\n" + warning;
  const bool ranges = e.range.count > 0;
  const auto range = [&](double metres) { return ranges ? metresCell(metres) : HtmlCell{}; };
  const bool clouds = cloud.to.count > 0 || cloud.from.count > 0;
  const auto distance = [&](const Spread& spread, double metres) {
    return clouds && spread.count > 0 ? metresCell(metres) : HtmlCell{};
  };
  const GroupErrors* away = awayFromEdges(s.measured.errors);
  std::vector<HtmlCell> cells{
      {s.setting.name, std::nan(""), hint},
      {secondsText(cost.scanSeconds), cost.scanSeconds,
       fmt::format("{} to {}", secondsText(cost.fastest), secondsText(cost.slowest))},
      amountCell(beamsPerSecond(study, s)),
      ratio,
      range(e.range.p99),
      away != nullptr && away->range.count > 0 ? metresCell(away->range.p99) : HtmlCell{},
      shareCell(e.labels()),
      beamsCell(e.falseNegatives, e.beams),
      beamsCell(e.falsePositives, e.beams),
      secondsCell(cost.setupSeconds),
      {cost.slowest > 0 ? fmt::format("{} \xE2\x80\x93 {}", secondsText(cost.fastest), secondsText(cost.slowest)) : "",
       cost.slowest},
      {shortBytes(static_cast<double>(cost.memoryBytes)), static_cast<double>(cost.memoryBytes),
       fmt::format("the process grew by {}", shortBytes(static_cast<double>(cost.residentBytes)))},
      range(e.range.median),
      range(e.range.p95),
      range(e.range.p999),
      range(e.range.max),
      range(e.range.mean),
      range(e.range.rms),
      beamsCell(e.unresolved, e.beams),
      shareCell(e.classAgreed()),
      shareCell(e.instanceAgreed()),
      e.intensity.count > 0 ? HtmlCell{fmt::format("{:.3g}", e.intensity.mean), e.intensity.mean} : HtmlCell{},
      distance(cloud.to, cloud.to.mean),
      distance(cloud.from, cloud.from.mean),
      clouds ? metresCell(cloud.hausdorff) : HtmlCell{}};
  table.row(std::move(cells), front);
}

const GroupErrors* errorsNamed(const std::vector<ErrorGroup>& groups, const std::string& name) {
  for (const ErrorGroup& g : groups) {
    if (g.name == name) return &g.errors;
  }
  return nullptr;
}

}  // namespace

std::string settingsTable(const Study& study) {
  HtmlTable table;
  table.group("", 1);
  table.group("time", 3);
  table.group("range error", 2);
  table.group("beams", 3);
  table.group("set-up, spread of times, memory", 3);
  table.group("more of the range error", 6);
  table.group("more of the beams", 4);
  table.group("nearest neighbours", 3);
  table.column("setting");
  table.column("a scan", "median over all repeats of all scans");
  table.column("beams/s");
  table.column("x ray tracing", "times ray tracing with its defaults takes");
  table.column("p99", "99 % of the beams that both hit stay below");
  table.column("p99 away from edges", "likewise, of the beams that do not lie at an edge");
  table.column("labels", "class and instance agree, of the beams that both hit");
  table.column("false negatives", kFalseNegativeHint);
  table.column("false positives", kFalsePositiveHint);
  table.column("set-up", "making the method and preparing it for the first scan");
  table.column("fastest \xE2\x80\x93 slowest", "scan");
  table.column("memory", "by the method's own account");
  for (const char* name : {"median", "p95", "p99.9", "max", "mean", "RMS"}) table.column(name);
  table.column("unresolved", "the setting gave up");
  table.column("class", "agrees, of the beams that both hit");
  table.column("instance", "agrees, of the beams that both hit");
  table.column("intensity", "mean error, in the intensity's own unit");
  table.column("to", kNearestHint);
  table.column("from", "mean distance from each of the setting's points to the nearest true one");
  table.column("Hausdorff", kHausdorffHint);
  const std::vector<std::size_t> byRange = rangeFront(study), byWrong = wrongFront(study);
  for (std::size_t i = 0; i < study.settings.size(); ++i) {
    const SettingResult& s = study.settings[i];
    if (s.failure.empty()) {
      settingRow(table, study, i, isIn(byRange, i) || isIn(byWrong, i));
    } else {
      table.failure(s.setting.name, "not measured: " + s.failure);
    }
  }
  return table.empty() ? "" : table.html();
}

std::string classesTable(const Study& study) {
  const std::vector<std::size_t> shown = shownSettings(study, kMostColumns);
  HtmlTable table;
  table.group("", 2);
  table.column("class");
  table.column("beams", "that hit it in truth, or by the first of the settings where the truth hits nothing");
  std::vector<std::pair<std::string, std::uint64_t>> classes;
  for (const std::size_t i : shown) {
    const SettingResult& s = study.settings[i];
    table.group(s.setting.name, 3);
    table.column("labels");
    table.column("false negatives", kFalseNegativeHint);
    table.column("nearest", kNearestHint);
    for (const ErrorGroup& g : s.measured.errors.byClass) {
      const bool known = std::any_of(classes.begin(), classes.end(), [&](const auto& c) { return c.first == g.name; });
      if (!known && g.errors.beams > 0) classes.emplace_back(g.name, g.errors.beams);
    }
  }
  std::stable_sort(classes.begin(), classes.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  for (const auto& [name, beams] : classes) {
    std::vector<HtmlCell> cells{{name}, countCell(beams)};
    for (const std::size_t i : shown) {
      const GroupErrors* e = errorsNamed(study.settings[i].measured.errors.byClass, name);
      const bool any = e != nullptr && e->beams > 0;
      cells.push_back(any && e->bothHit > 0 ? shareCell(e->labels()) : HtmlCell{});
      cells.push_back(any && e->bothHit + e->falseNegatives > 0 ? shareCell(falseNegativeShare(*e)) : HtmlCell{});
      cells.push_back(any ? nearestCell(*e) : HtmlCell{});
    }
    table.row(std::move(cells));
  }
  return table.empty() ? "" : table.html();
}

std::string placesTable(const Study& study) {
  HtmlTable table;
  std::vector<std::string> places;
  table.group("", 1);
  table.column("setting");
  for (const std::size_t i : measuredSettings(study)) {
    for (const ErrorGroup& g : study.settings[i].measured.errors.byPlace) {
      if (g.errors.beams == 0 || std::find(places.begin(), places.end(), g.name) != places.end()) continue;
      places.push_back(g.name);
      table.group(placeText(g.name), 7);
      for (const char* name : {"beams", "median", "p99", "labels", "false negatives or positives"}) table.column(name);
      table.column("nearest", kNearestHint);
      table.column("Hausdorff", kHausdorffHint);
    }
  }
  if (places.empty()) return "";
  for (const std::size_t i : measuredSettings(study)) {
    std::vector<HtmlCell> cells{{study.settings[i].setting.name}};
    for (const std::string& place : places) {
      const GroupErrors* e = errorsNamed(study.settings[i].measured.errors.byPlace, place);
      if (e == nullptr || e->beams == 0) {
        cells.insert(cells.end(), 7, HtmlCell{});
        continue;
      }
      cells.insert(cells.end(), {countCell(e->beams), metresCell(e->range.median), metresCell(e->range.p99),
                                 shareCell(e->labels()), shareCell(e->missRate()), nearestCell(*e), hausdorffCell(*e)});
    }
    table.row(std::move(cells));
  }
  return table.html();
}

std::string stagesTables(const Study& study) {
  const std::vector<std::size_t> rows = settingsByMethod(study, kReportRows);
  std::string out;
  for (const std::string& method : methodsOf(study)) out += stagesTable(study, method, rows);
  return out;
}

std::string encodingsTable(const Study& study) {
  HtmlTable table;
  table.column("encoding");
  table.column("points/s", "encoded, on one thread");
  table.column("points/s decoded", "on one thread");
  table.column("bytes a point");
  table.column("largest error", "of a position, measured by decoding");
  table.column("promised", "the largest error that the format promises");
  for (const EncodingResult& e : study.encodings) {
    if (!e.failure.empty()) {
      table.failure(e.name, "not measured: " + e.failure);
      continue;
    }
    table.row({{e.name},
               amountCell(e.encodePointsPerSecond),
               amountCell(e.decodePointsPerSecond),
               {fmt::format("{:.2f}", e.bytesPerPoint), e.bytesPerPoint},
               metresCell(e.largestError),
               metresCell(e.statedError)});
  }
  return table.empty() ? "" : table.html();
}

std::string sensingTable(const Study& study) {
  HtmlTable table;
  table.column("setting");
  table.column("trace", "a scan, on all threads");
  table.column("effects", "a scan, on one thread");
  table.column("missing", "beams that return in truth alone");
  table.column("added", "beams that return in the setting alone");
  table.column("median", "distance between the two points of a beam that returns in both");
  table.column("p95", "of the distance");
  table.column("p99", "of the distance");
  table.column("other class", "of the beams that return in both");
  table.column("intensity", "its mean difference, in its own unit");
  for (const SensingResult& r : study.sensing) {
    if (!r.failure.empty()) {
      table.failure(r.name, "not measured: " + r.failure);
      continue;
    }
    const auto share = [](std::uint64_t part, std::uint64_t whole) {
      const double s = whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
      return HtmlCell{shareText(s), s};
    };
    table.row({{r.name},
               {secondsText(r.traceSeconds), r.traceSeconds},
               {secondsText(r.effectsSeconds), r.effectsSeconds},
               share(r.missing, r.beams),
               share(r.added, r.beams),
               metresCell(r.distance.median),
               metresCell(r.distance.p95),
               metresCell(r.distance.p99),
               share(r.both - r.sameClass, r.both),
               {fmt::format("{:.3g}", r.intensity), r.intensity}});
  }
  return table.empty() ? "" : table.html();
}

std::string ringsTable(const Study& study) {
  std::vector<std::uint32_t> rings;
  std::vector<std::pair<std::string, const RingFit*>> fits;
  for (const RingFit& f : study.rings) fits.emplace_back(f.setting.name, &f);
  if (study.showing) fits.emplace_back("drawing a picture of the scan", &*study.showing);
  for (const auto& [name, fit] : fits) {
    for (const RingTiming& t : fit->timings) rings.push_back(t.rings);
  }
  std::sort(rings.begin(), rings.end());
  rings.erase(std::unique(rings.begin(), rings.end()), rings.end());
  HtmlTable table;
  table.column("setting");
  for (const std::uint32_t count : rings) table.column(fmt::format("{} rings", count));
  table.column("fixed", "of the fit");
  table.column("a ring", "of the fit");
  table.column("off by", "the largest relative residual of the fit");
  for (const auto& [name, fit] : fits) {
    std::vector<HtmlCell> cells{{name}};
    for (const std::uint32_t count : rings) {
      const auto timing = std::find_if(fit->timings.begin(), fit->timings.end(),
                                       [count = count](const RingTiming& t) { return t.rings == count; });
      cells.push_back(timing == fit->timings.end() ? HtmlCell{} : secondsCell(timing->scanSeconds));
    }
    cells.push_back(secondsCell(fit->fixedSeconds));
    cells.push_back(secondsCell(fit->secondsPerRing));
    cells.push_back({fmt::format("{:.1f} %", fit->largestResidual * 100), fit->largestResidual});
    table.row(std::move(cells));
  }
  return table.empty() ? "" : table.html();
}

std::string assignmentsTable(const Study& study) {
  HtmlTable table;
  table.column("setting");
  table.column("on a command line");
  for (const std::size_t i : measuredSettings(study)) {
    table.row({{study.settings[i].setting.name}, {setArgument(study.settings[i].setting)}});
  }
  return table.empty() ? "" : table.html();
}

}  // namespace scanmill
