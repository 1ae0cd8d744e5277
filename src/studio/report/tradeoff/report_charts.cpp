#include "report/tradeoff/report_charts.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "charts/chart.h"
#include "report/tradeoff/report_figures.h"
#include "study/figure_text.h"
#include "study/tradeoff/study_figures.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostLines = 6, kMostClasses = 30;
constexpr int kHalfWidth = 575;  // pixels of charts that stand side by side
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
const std::string kRangeError = "range error that 99 % of the beams stay below";
const std::string kNearest = "mean distance from true points to the setting's nearest";
const std::string kWrongBeams = "false negatives, false positives and wrongly labelled beams";

using Groups = std::vector<ErrorGroup> BeamErrors::*;
using Error = std::function<double(const GroupErrors&)>;

ChartAxis metresAxis(const std::string& title) {
  return {.title = title, .scale = AxisScale::Log, .unit = "m", .zero = "exact"};
}

ChartAxis sharesAxis(const std::string& title) {
  return {.title = title, .scale = AxisScale::Log, .unit = "%", .zero = "none"};
}

double noBeams(const GroupErrors& e, double value) {
  return e.beams == 0 ? kNone : value;
}
double rangeErrorOf(const GroupErrors& e) {
  return rangeP99(e);
}
double nearestOf(const GroupErrors& e) {
  return nearestMean(e);
}
double wrongOf(const GroupErrors& e) {
  return noBeams(e, wrongShare(e));
}
double falseNegativesOf(const GroupErrors& e) {
  return e.bothHit + e.falseNegatives == 0 ? kNone : falseNegativeShare(e);
}

const ErrorGroup* groupNamed(const std::vector<ErrorGroup>& groups, const std::string& name) {
  const auto found = std::find_if(groups.begin(), groups.end(), [&](const ErrorGroup& g) { return g.name == name; });
  return found == groups.end() ? nullptr : &*found;
}

// Those with beams, in their order.
std::vector<std::string> groupNames(const Study& study, const std::vector<std::size_t>& settings, Groups groups) {
  std::vector<std::string> names;
  for (const std::size_t i : settings) {
    for (const ErrorGroup& g : study.settings[i].measured.errors.*groups) {
      const bool known = std::find(names.begin(), names.end(), g.name) != names.end();
      if (g.errors.beams > 0 && !known) names.push_back(g.name);
    }
  }
  return names;
}

std::string valueText(double value, const std::string& unit) {
  return unit == "m" ? value == 0 ? "exact" : metresText(value) : shareText(value);
}

// So that equal values do not cover each other: where the k-th of `count` series lies beside its place.
double beside(std::size_t k, std::size_t count, double step) {
  return (static_cast<double>(k) - (static_cast<double>(count) - 1) / 2) * step;
}

// What a mark of a setting says when pointed at.
std::string settingDetail(const Study& study, const SettingResult& s) {
  const GroupErrors& e = s.measured.errors.all;
  return fmt::format(
      "{}\n{} beams/s, {} a scan\nrange error: median {}, p99 {}\nlabels {}, false negatives or positives {}",
      s.setting.name, amountText(beamsPerSecond(study, s)), secondsText(s.measured.cost.scanSeconds),
      metresText(e.range.median), metresText(e.range.p99), shareText(e.labels()), shareText(e.missRate()));
}

// Without the method's name, which colour and shape give.
std::string shortName(const Setting& setting) {
  return setting.name.starts_with(setting.method + " ") ? setting.name.substr(setting.method.size() + 1)
                                                        : wordsOf(setting.name);
}

std::string sceneNote(const Study& study) {
  std::string sensors;
  for (const std::string& s : study.sensors) sensors += (sensors.empty() ? "" : "; ") + s;
  return fmt::format("{}; {}; {}, {}", study.scene.key.empty() ? study.pipelineName : study.scene.key, sensors,
                     study.machine.processor, pluralOf(static_cast<std::uint64_t>(study.machine.threads), "thread"));
}

// The staircase that no setting gets past, but for steps too small to tell from the noise of time.
ChartSeries frontLine(const std::vector<Vec2d>& front, const std::vector<Vec2d>& all) {
  ChartSeries line{.name = "Pareto front: nothing is both faster and better",
                   .color = 6,
                   .mark = ChartMark::Line,
                   .emphasised = true};
  double slowest = front.front().x, worst = front.front().y;
  for (const Vec2d& p : all) {
    if (p.x > 0) slowest = std::min(slowest, p.x);
    worst = std::max(worst, p.y);
  }
  double before = worst;
  for (const Vec2d& p : front) {
    line.points.push_back({p.x, before});
    line.points.push_back(p);
    before = p.y;
  }
  line.points.push_back({slowest, before});
  return line;
}

std::string frontChart(const Study& study, Chart chart, const Error& error, const std::vector<std::size_t>& front) {
  const std::vector<std::string> methods = methodsOf(study);
  std::vector<Vec2d> all, onFront;
  const auto place = [&](std::size_t i) {
    return Vec2d{beamsPerSecond(study, study.settings[i]), error(study.settings[i].measured.errors.all)};
  };
  for (const std::size_t i : measuredSettings(study)) {
    if (std::isfinite(place(i).y)) all.push_back(place(i));
  }
  for (const std::size_t i : front) onFront.push_back(place(i));
  if (!onFront.empty()) chart.series.push_back(frontLine(onFront, all));
  for (const bool emphasised : {true, false}) {
    for (const std::string& method : methods) {
      ChartSeries byDefault{.name = wordsOf(method), .color = methodColor(study, method), .emphasised = emphasised};
      ChartSeries others = byDefault;
      byDefault.labelsFirst = true;
      for (const std::size_t i : measuredSettings(study)) {
        const SettingResult& s = study.settings[i];
        const bool on = std::find(front.begin(), front.end(), i) != front.end();
        if (s.setting.method != method || on != emphasised) continue;
        ChartSeries& series = isDefault(s.setting) ? byDefault : others;
        series.points.push_back(place(i));
        series.labels.push_back(shortName(s.setting));
        series.details.push_back(settingDetail(study, s));
      }
      chart.series.push_back(std::move(byDefault));
      chart.series.push_back(std::move(others));
    }
  }
  chart.x = {.title = "beams a second (to the right is better)", .scale = AxisScale::Log};
  return drawSvg(chart);
}

std::string rangeChart(const Study& study, int width, int height) {
  Chart chart{.title = "Speed against range error", .note = sceneNote(study)};
  chart.y = metresAxis(kRangeError + " (lower is better)");
  chart.width = width;
  chart.height = height;
  return frontChart(study, std::move(chart), rangeErrorOf, rangeFront(study));
}

std::vector<std::size_t> colorsOf(const Study& study, const std::vector<std::size_t>& settings) {
  std::vector<std::string> methods;
  methods.reserve(settings.size());
  for (const std::size_t i : settings) methods.push_back(study.settings[i].setting.method);
  return settingColors(study, methods);
}

// A line per shown setting over bands.
std::string bandChart(const Study& study, const std::string& title, const std::string& bands, Groups groups,
                      const ChartAxis& y, const Error& error) {
  const std::vector<std::size_t> shown = shownSettings(study, kMostLines);
  const std::vector<std::size_t> colors = colorsOf(study, shown);
  Chart chart{.title = title, .x = {.title = bands, .names = groupNames(study, shown, groups)}, .y = y};
  chart.width = kHalfWidth;
  chart.height = 400;
  if (chart.x.names.empty()) return "";
  for (std::size_t k = 0; k < shown.size(); ++k) {
    const SettingResult& s = study.settings[shown[k]];
    ChartSeries series{.name = s.setting.name, .color = colors[k], .mark = ChartMark::LineAndDots};
    for (std::size_t b = 0; b < chart.x.names.size(); ++b) {
      const ErrorGroup* group = groupNamed(s.measured.errors.*groups, chart.x.names[b]);
      const double value = group == nullptr ? kNone : error(group->errors);
      series.points.push_back({static_cast<double>(b) + beside(k, shown.size(), 0.09), value});
      series.details.push_back(fmt::format("{}\n{}: {}", s.setting.name, chart.x.names[b], valueText(value, y.unit)));
    }
    chart.series.push_back(std::move(series));
  }
  return drawSvg(chart);
}

std::string recallChart(const Study& study, const std::string& title, const std::string& sizes,
                        std::vector<SizeRecall> BeamErrors::*recall) {
  const std::vector<std::size_t> shown = shownSettings(study, kMostLines);
  const std::vector<std::size_t> colors = colorsOf(study, shown);
  Chart chart{.title = title, .note = "things of which at least one beam is met, of those that a true beam meets"};
  chart.x.title = sizes;
  chart.y = {.title = "things found", .unit = "%", .high = 1};
  chart.width = kHalfWidth;
  chart.height = 390;
  if (shown.empty()) return "";
  std::vector<std::size_t> bands;
  const std::vector<SizeRecall>& first = study.settings[shown.front()].measured.errors.*recall;
  for (std::size_t b = 0; b < first.size(); ++b) {
    if (first[b].things == 0) continue;
    bands.push_back(b);
    chart.x.names.push_back(fmt::format("{} ({})", first[b].name, first[b].things));
  }
  if (bands.empty()) return "";
  for (std::size_t k = 0; k < shown.size(); ++k) {
    const SettingResult& s = study.settings[shown[k]];
    const std::vector<SizeRecall>& own = s.measured.errors.*recall;
    ChartSeries series{.name = s.setting.name, .color = colors[k], .mark = ChartMark::LineAndDots};
    for (std::size_t at = 0; at < bands.size(); ++at) {
      const SizeRecall* band = bands[at] < own.size() ? &own[bands[at]] : nullptr;
      const bool any = band != nullptr && band->things > 0;
      const double found = any ? static_cast<double>(band->thingsFound) / static_cast<double>(band->things) : kNone;
      series.points.push_back({static_cast<double>(at) + beside(k, shown.size(), 0.09), found});
      series.details.push_back(any ? fmt::format("{}\n{}: {} of {} things, {} of {} beams", s.setting.name, band->name,
                                                 band->thingsFound, band->things, band->beamsFound, band->beams)
                                   : "");
    }
    chart.series.push_back(std::move(series));
  }
  return drawSvg(chart);
}

// A row per setting, a dot per place.
std::string placeChart(const Study& study, const std::string& title, const ChartAxis& x, const Error& error) {
  const std::vector<std::size_t> rows = settingsByMethod(study, kReportRows);
  const std::vector<std::string> places = groupNames(study, rows, &BeamErrors::byPlace);
  if (places.empty()) return "";
  Chart chart{.title = title, .x = x};
  for (const std::size_t i : rows) chart.y.names.push_back(study.settings[i].setting.name);
  for (std::size_t k = 0; k < places.size(); ++k) {
    ChartSeries series{.name = placeText(places[k]), .color = k + 3};  // not those of methods
    for (std::size_t row = 0; row < rows.size(); ++row) {
      const SettingResult& s = study.settings[rows[row]];
      const ErrorGroup* group = groupNamed(s.measured.errors.byPlace, places[k]);
      const double value = group == nullptr ? kNone : error(group->errors);
      series.points.push_back({value, static_cast<double>(row) + beside(k, places.size(), 0.2)});
      series.details.push_back(fmt::format("{}\n{}: {}", s.setting.name, series.name, valueText(value, x.unit)));
    }
    chart.series.push_back(std::move(series));
  }
  chart.width = kHalfWidth;
  chart.height = 130 + 20 * static_cast<int>(rows.size());
  return drawSvg(chart);
}

// A row per class, the most frequent first, a dot per shown setting.
std::string classChart(const Study& study, const std::string& title, const std::string& x, const Error& error) {
  const std::vector<std::size_t> shown = shownSettings(study, kMostLines);
  const std::vector<std::size_t> colors = colorsOf(study, shown);
  if (shown.empty()) return "";
  std::vector<std::string> names = groupNames(study, shown, &BeamErrors::byClass);
  const auto beams = [&](const std::string& name) {
    std::uint64_t most = 0;
    for (const std::size_t i : shown) {
      const ErrorGroup* group = groupNamed(study.settings[i].measured.errors.byClass, name);
      if (group != nullptr) most = std::max(most, group->errors.beams);
    }
    return most;
  };
  std::stable_sort(names.begin(), names.end(), [&](const auto& a, const auto& b) { return beams(a) > beams(b); });
  if (names.size() > kMostClasses) names.resize(kMostClasses);
  if (names.empty()) return "";
  Chart chart{.title = title, .x = sharesAxis(x), .y = {.names = names}};
  std::string spotless;
  for (std::size_t k = 0; k < shown.size(); ++k) {
    const SettingResult& s = study.settings[shown[k]];
    ChartSeries series{.name = s.setting.name, .color = colors[k]};
    for (std::size_t row = 0; row < names.size(); ++row) {
      const ErrorGroup* group = groupNamed(s.measured.errors.byClass, names[row]);
      const double value = group == nullptr ? kNone : error(group->errors);
      series.points.push_back({value, static_cast<double>(row) + beside(k, shown.size(), 0.11)});
      series.details.push_back(fmt::format("{}\n{}: {}", s.setting.name, names[row], shareText(value)));
    }
    const bool errs = std::any_of(series.points.begin(), series.points.end(), [](const Vec2d& p) { return p.x > 0; });
    if (errs) {
      chart.series.push_back(std::move(series));
    } else {
      spotless += (spotless.empty() ? "" : ", ") + s.setting.name;
    }
  }
  if (chart.series.empty()) return "";
  if (!spotless.empty()) chart.note = fmt::format("none in any class: {}", spotless);
  chart.width = kHalfWidth;
  chart.height = 170 + 27 * static_cast<int>(names.size());
  return drawSvg(chart);
}

}  // namespace

std::string paretoSvg(const Study& study) {
  return rangeChart(study, 880, 540);
}

std::string rangeFrontChart(const Study& study) {
  return rangeChart(study, kReportWidth, 560);
}

std::string wrongFrontChart(const Study& study) {
  Chart chart{.title = "Speed against wrong beams",
              .note = "beams that only one of truth and setting hits, or whose class or instance differs"};
  chart.y = sharesAxis(kWrongBeams + " (lower is better)");
  chart.width = kReportWidth;
  chart.height = 520;
  return frontChart(study, std::move(chart), wrongOf, wrongFront(study));
}

std::string rangeErrorByRange(const Study& study) {
  return bandChart(study, "Range error by range", "range", &BeamErrors::byRange, metresAxis(kRangeError), rangeErrorOf);
}
std::string wrongByRange(const Study& study) {
  return bandChart(study, "Wrong beams by range", "range", &BeamErrors::byRange, sharesAxis(kWrongBeams), wrongOf);
}
std::string rangeErrorByIncidence(const Study& study) {
  return bandChart(study, "Range error by incidence", "angle between beam and surface normal", &BeamErrors::byIncidence,
                   metresAxis(kRangeError), rangeErrorOf);
}
std::string wrongByIncidence(const Study& study) {
  return bandChart(study, "Wrong beams by incidence", "angle between beam and surface normal", &BeamErrors::byIncidence,
                   sharesAxis(kWrongBeams), wrongOf);
}
std::string nearestByRange(const Study& study) {
  return bandChart(study, "Distance to the nearest point, by range", "range", &BeamErrors::byRange,
                   metresAxis(kNearest), nearestOf);
}
std::string nearestByIncidence(const Study& study) {
  return bandChart(study, "Distance to the nearest point, by incidence", "angle between beam and surface normal",
                   &BeamErrors::byIncidence, metresAxis(kNearest), nearestOf);
}
std::string recallByThickness(const Study& study) {
  return recallChart(study, "Thin things found", "smallest side of the thing's box (how many things)",
                     &BeamErrors::byThickness);
}
std::string recallByLength(const Study& study) {
  return recallChart(study, "Small things found", "largest side of the thing's box (how many things)",
                     &BeamErrors::byLength);
}
std::string rangeErrorByPlace(const Study& study) {
  return placeChart(study, "Range error at edges and away from edges", metresAxis(kRangeError), rangeErrorOf);
}
std::string wrongByPlace(const Study& study) {
  return placeChart(study, "Wrong beams at edges and away from edges", sharesAxis(kWrongBeams), wrongOf);
}
std::string wrongByClass(const Study& study) {
  return classChart(study, "Wrong beams by class", kWrongBeams, wrongOf);
}
std::string falseNegativesByClass(const Study& study) {
  return classChart(study, "False negatives by class", "beams that hit the class in truth and nothing by the setting",
                    falseNegativesOf);
}

}  // namespace scanmill
