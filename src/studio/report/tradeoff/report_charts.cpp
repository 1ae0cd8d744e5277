#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "report/tradeoff/report.h"
#include "study/figure_text.h"
#include "study/tradeoff/study_figures.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostLines = 6, kMostClasses = 30;
constexpr int kWide = 1160, kHalf = 575;  // width in pixels of charts alone in a row, and of charts side by side
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kSmallStage = 0.03;  // fraction of a scan's time; smaller stages are combined to "the rest"
const std::string kRest = "the rest";

// A measure of error that charts show on a logarithmic axis.
struct Measure {
  const char* title;
  const char* unit;  // "m" or "%"
  std::function<double(const GroupErrors&)> of;

  ChartAxis axis(const char* more = "") const {
    return {.title = std::string(title) + more,
            .scale = AxisScale::Log,
            .unit = unit,
            .zero = *unit == 'm' ? "exact" : "none"};
  }
  std::string text(double value) const {
    return *unit != 'm' ? shareText(value) : value == 0 ? "exact" : metresText(value);
  }
};

const Measure kRangeError{"p99 of the range error: 99 % of the beams have less", "m", rangeP99};
const Measure kNearest{"mean distance from true points to the nearest of the setting", "m", nearestMean};
const Measure kWrong{"false negatives, false positives and wrongly labelled beams", "%",
                     [](const GroupErrors& e) { return e.beams == 0 ? kNone : wrongShare(e); }};
const Measure kFalseNegatives{
    "beams that hit the class in truth and miss by the setting", "%",
    [](const GroupErrors& e) { return e.bothHit + e.falseNegatives == 0 ? kNone : falseNegativeShare(e); }};

const BeamErrors& errorsOf(const Study& study, std::size_t setting) {
  return study.settings[setting].measured.errors;
}

// Returns the error of the group with this name; NaN if there is no such group.
double errorOf(const std::vector<ErrorGroup>& groups, const std::string& name, const Measure& measure) {
  const auto found = std::ranges::find_if(groups, [&](const ErrorGroup& g) { return g.name == name; });
  return found == groups.end() ? kNone : measure.of(found->errors);
}

// Returns the shift along an axis for the k-th of `count` series, so that points with equal values are drawn side by
// side.
double beside(std::size_t k, std::size_t count, double step) {
  return (static_cast<double>(k) - (static_cast<double>(count) - 1) / 2) * step;
}

std::string settingDetail(const Study& study, const SettingResult& s) {
  const GroupErrors& e = s.measured.errors.all;
  return fmt::format(
      "{}\n{} beams/s, {} a scan\nrange error: median {}, p99 {}\nlabels {}, false negatives or positives {}",
      s.setting.name, amountText(beamsPerSecond(study, s)), secondsText(s.measured.cost.scanSeconds),
      metresText(e.range.median), metresText(e.range.p99), shareText(e.labels()), shareText(e.missRate()));
}

// Returns the setting's name without the method, which the chart shows by colour and shape.
std::string shortName(const Setting& setting) {
  return setting.name.starts_with(setting.method + " ") ? setting.name.substr(setting.method.size() + 1)
                                                        : wordsOf(setting.name);
}

std::string sceneNote(const Study& study) {
  return fmt::format("{}; {}; {}, {}", study.scene.key.empty() ? study.pipelineName : study.scene.key,
                     fmt::join(study.sensors, "; "), study.machine.processor,
                     pluralOf(static_cast<std::uint64_t>(study.machine.threads), "thread"));
}

// Returns the Pareto front as a staircase line. `front`: points (beams per second, error) on the front. `all`: all
// points, which determine the ends of the line.
ChartSeries frontLine(const std::vector<Vec2d>& front, const std::vector<Vec2d>& all) {
  ChartSeries line{.name = "Pareto front: no setting is both faster and better",
                   .color = 6,
                   .mark = ChartMark::Line,
                   .emphasised = true};
  double slowest = front.front().x, before = front.front().y;
  for (const Vec2d& p : all) {
    if (p.x > 0) slowest = std::min(slowest, p.x);
    before = std::max(before, p.y);
  }
  for (const Vec2d& p : front) {
    line.points.insert(line.points.end(), {{p.x, before}, p});
    before = p.y;
  }
  line.points.push_back({slowest, before});
  return line;
}

Chart frontChart(const Study& study, Chart chart, const Measure& measure, const std::vector<std::size_t>& front) {
  chart.x = {.title = "beams per second (right is better)", .scale = AxisScale::Log};
  chart.y = measure.axis(" (lower is better)");
  chart.height = 560;
  const std::vector<std::size_t> measured = measuredSettings(study);
  std::vector<Vec2d> all, onFront;
  const auto place = [&](std::size_t i) {
    return Vec2d{beamsPerSecond(study, study.settings[i]), measure.of(errorsOf(study, i).all)};
  };
  for (const std::size_t i : measured) {
    if (std::isfinite(place(i).y)) all.push_back(place(i));
  }
  for (const std::size_t i : front) onFront.push_back(place(i));
  if (!onFront.empty()) chart.series.push_back(frontLine(onFront, all));
  for (const bool emphasised : {true, false}) {
    for (const std::string& method : methodsOf(study)) {
      ChartSeries byDefault{.name = wordsOf(method), .color = methodColor(study, method), .emphasised = emphasised};
      ChartSeries others = byDefault;
      byDefault.labelsFirst = true;
      for (const std::size_t i : measured) {
        const SettingResult& s = study.settings[i];
        const bool on = std::ranges::find(front, i) != front.end();
        if (s.setting.method != method || on != emphasised) continue;
        ChartSeries& series = isDefault(s.setting) ? byDefault : others;
        series.add(place(i), settingDetail(study, s));
        series.labels.push_back(shortName(s.setting));
      }
      chart.series.insert(chart.series.end(), {byDefault, others});
    }
  }
  return chart;
}

// The settings in a chart and their colours (indices in the palette).
struct Shown {
  explicit Shown(const Study& study) : settings(shownSettings(study, kMostLines)) {
    std::vector<std::string> methods;
    for (const std::size_t i : settings) methods.push_back(study.settings[i].setting.method);
    colors = settingColors(study, methods);
  }
  std::vector<std::size_t> settings, colors;
};

// Returns the value of a setting for the name with index `name` on the axis, and the text for its mark. The value is
// NaN if there is none.
using Figure = std::function<std::pair<double, std::string>(const BeamErrors& errors, std::size_t name)>;

// Returns the chart with one series per setting. Each series has one value per name on the y axis; if the y axis has no
// names, one per name on the x axis.
Chart settingsChart(const Study& study, const Shown& shown, Chart chart, ChartMark mark, double step,
                    const Figure& figure) {
  const bool lying = !chart.y.names.empty();
  chart.width = kHalf;
  for (std::size_t k = 0; k < shown.settings.size(); ++k) {
    const std::string& name = study.settings[shown.settings[k]].setting.name;
    ChartSeries series{.name = name, .color = shown.colors[k], .mark = mark};
    for (std::size_t n = 0; n < (lying ? chart.y : chart.x).names.size(); ++n) {
      const auto [value, detail] = figure(errorsOf(study, shown.settings[k]), n);
      const double place = static_cast<double>(n) + beside(k, shown.settings.size(), step);
      series.add(lying ? Vec2d{value, place} : Vec2d{place, value}, name + "\n" + detail);
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

Chart bandChart(const Study& study, Chart chart, const char* bands, Groups groups, const Measure& measure) {
  const Shown shown(study);
  const std::vector<std::string> names = groupNames(study, shown.settings, groups);
  chart.x = {.title = bands, .names = names};
  chart.y = measure.axis();
  chart.height = 400;
  return settingsChart(study, shown, std::move(chart), ChartMark::LineAndDots, 0.09,
                       [&](const BeamErrors& errors, std::size_t n) {
                         const double value = errorOf(errors.*groups, names[n], measure);
                         return std::pair(value, fmt::format("{}: {}", names[n], measure.text(value)));
                       });
}

Chart recallChart(const Study& study, Chart chart, const char* sizes, std::vector<SizeRecall> BeamErrors::*recall) {
  const Shown shown(study);
  chart.note = "share of the things with a true hit that at least one beam hits";
  chart.x.title = sizes;
  chart.y = {.title = "things found", .unit = "%", .high = 1};
  chart.height = 390;
  std::vector<std::size_t> bands;
  for (std::size_t b = 0; !shown.settings.empty() && b < (errorsOf(study, shown.settings[0]).*recall).size(); ++b) {
    const SizeRecall& first = (errorsOf(study, shown.settings[0]).*recall)[b];
    if (first.things == 0) continue;
    bands.push_back(b);
    chart.x.names.push_back(fmt::format("{} ({})", first.name, first.things));
  }
  return settingsChart(
      study, shown, std::move(chart), ChartMark::LineAndDots, 0.09, [&](const BeamErrors& errors, std::size_t n) {
        const std::vector<SizeRecall>& own = errors.*recall;
        const SizeRecall band = bands[n] < own.size() ? own[bands[n]] : SizeRecall{};
        return std::pair(
            band.things > 0 ? static_cast<double>(band.thingsFound) / static_cast<double>(band.things) : kNone,
            fmt::format("{}: {} of {} things, {} of {} beams", band.name, band.thingsFound, band.things,
                        band.beamsFound, band.beams));
      });
}

// Returns a chart with one row per setting, and in each row one dot per group of beams (at edges, away from edges).
Chart placeChart(const Study& study, Chart chart, const Measure& measure) {
  const std::vector<std::size_t> rows = settingsByMethod(study, kReportRows);
  const std::vector<std::string> places = groupNames(study, rows, &BeamErrors::byPlace);
  chart.x = measure.axis();
  chart.width = kHalf;
  chart.height = 130 + 20 * static_cast<int>(rows.size());
  for (const std::size_t i : rows) chart.y.names.push_back(study.settings[i].setting.name);
  for (std::size_t k = 0; k < places.size(); ++k) {
    ChartSeries series{.name = placeText(places[k]), .color = k + 3};  // the first three colours are those of methods
    for (std::size_t row = 0; row < rows.size(); ++row) {
      const double value = errorOf(errorsOf(study, rows[row]).byPlace, places[k], measure);
      series.add({value, static_cast<double>(row) + beside(k, places.size(), 0.2)},
                 fmt::format("{}\n{}: {}", chart.y.names[row], series.name, measure.text(value)));
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

// Returns a chart with one row per class, the most frequent first, and in each row one dot per setting.
Chart classChart(const Study& study, Chart chart, const Measure& measure) {
  const Shown shown(study);
  std::vector<std::string> names = groupNames(study, shown.settings, &BeamErrors::byClass);
  const auto beams = [&](const std::string& name) {
    double most = 0;
    const Measure count{"", "", [](const GroupErrors& e) { return static_cast<double>(e.beams); }};
    for (const std::size_t i : shown.settings) most = std::fmax(most, errorOf(errorsOf(study, i).byClass, name, count));
    return most;
  };
  std::ranges::stable_sort(names, [&](const auto& a, const auto& b) { return beams(a) > beams(b); });
  if (names.size() > kMostClasses) names.resize(kMostClasses);
  chart.x = measure.axis();
  chart.y.names = names;
  chart.height = 170 + 27 * static_cast<int>(names.size());
  chart = settingsChart(study, shown, std::move(chart), ChartMark::Dots, 0.11,
                        [&](const BeamErrors& errors, std::size_t n) {
                          const double value = errorOf(errors.byClass, names[n], measure);
                          return std::pair(value, fmt::format("{}: {}", names[n], shareText(value)));
                        });
  std::vector<std::string> spotless;
  std::erase_if(chart.series, [&](const ChartSeries& s) {
    const bool errs = std::ranges::any_of(s.points, [](const Vec2d& p) { return p.x > 0; });
    if (!errs) spotless.push_back(s.name);
    return !errs;
  });
  if (!spotless.empty()) chart.note = fmt::format("none in any class: {}", fmt::join(spotless, ", "));
  return chart;
}

// Returns the fraction of a scan's time that each stage takes.
std::map<std::string, double> sharesOfStages(const Cost& cost) {
  if (cost.stages.empty() || cost.scanSeconds <= 0) return {{"trace", 1}};
  double sum = 0;
  for (const auto& [stage, seconds] : cost.stages) sum += seconds;
  std::map<std::string, double> shares = cost.stages;
  for (auto& [stage, seconds] : shares) seconds /= std::max(sum, cost.scanSeconds);
  return shares;
}

Chart stagesChart(const Study& study) {
  constexpr std::array<std::size_t, 7> kBarColors{0, 1, 2, 3, 4, 5, 7};
  const std::vector<std::size_t> rows = settingsByMethod(study, kReportRows);
  Chart chart{.name = "stages",
              .title = "Where a scan's time goes",
              .note =
                  "median time of a scan, divided into the method's stages; stages that run at the same time share it "
                  "in proportion to their processor time",
              .x = {.title = "time a scan", .unit = "s"},
              .stacked = true,
              .width = kWide,
              .height = 130 + 22 * static_cast<int>(rows.size())};
  std::vector<std::string> stages;  // stages that take a notable time in at least one setting, then "the rest"
  for (const std::size_t i : rows) {
    chart.y.names.push_back(study.settings[i].setting.name);
    for (const auto& [stage, share] : sharesOfStages(study.settings[i].measured.cost)) {
      const bool known = std::ranges::find(stages, stage) != stages.end();
      if (share >= kSmallStage && !known) stages.push_back(stage);
    }
  }
  stages.push_back(kRest);
  for (std::size_t k = 0; k < stages.size(); ++k) {
    ChartSeries series{.name = wordsOf(stages[k]),
                       .color = stages[k] == kRest ? 6 : kBarColors[k % kBarColors.size()],
                       .mark = ChartMark::Bars};
    for (std::size_t row = 0; row < rows.size(); ++row) {
      const double scan = study.settings[rows[row]].measured.cost.scanSeconds;
      const std::map<std::string, double> own = sharesOfStages(study.settings[rows[row]].measured.cost);
      const auto secondsOf = [&](const std::string& stage) { return own.contains(stage) ? own.at(stage) * scan : 0; };
      double seconds = secondsOf(stages[k]);
      if (stages[k] == kRest) {
        seconds = scan;
        for (const std::string& stage : stages) seconds -= secondsOf(stage);
        seconds = std::max(seconds, 0.0);
      }
      series.labels.push_back(k + 1 == stages.size() ? secondsText(scan) : "");
      series.add({seconds, static_cast<double>(row)}, fmt::format("{}\n{}: {} of {}", chart.y.names[row], stages[k],
                                                                  secondsText(seconds), secondsText(scan)));
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

Chart encodingsChart(const Study& study) {
  Chart chart{.name = "encodings",
              .title = "Encodings: size against speed",
              .note = "one thread; labels: the largest error of a position, measured by decoding",
              .x = {.title = "bytes per point (left is better)", .scale = AxisScale::Log},
              .y = {.title = "points encoded per second (higher is better)", .scale = AxisScale::Log},
              .width = kWide,
              .height = 420};
  for (const EncodingResult& e : study.encodings) {
    if (!e.failure.empty()) continue;
    auto series = std::ranges::find_if(chart.series, [&](const ChartSeries& s) { return s.name == e.format; });
    if (series == chart.series.end()) {
      series = chart.series.insert(series, {.name = e.format, .color = chart.series.size() % 7});
    }
    const std::string error = e.largestError == 0 ? "no error" : metresText(e.largestError);
    series->labels.push_back(fmt::format("{}: {}", e.name, error));
    series->add(
        {e.bytesPerPoint, e.encodePointsPerSecond},
        fmt::format("{}\n{:.2f} bytes a point, {} points/s encoded, {} points/s decoded\n{}", e.name, e.bytesPerPoint,
                    amountText(e.encodePointsPerSecond), amountText(e.decodePointsPerSecond), error));
  }
  return chart;
}

Chart ringsChart(const Study& study) {
  constexpr int kSteps = 48;  // number of segments of a line
  Chart chart{
      .name = "rings",
      .title = "Time a scan against rings",
      .note = "dots: measured; lines: a fixed cost and a cost per ring, fitted by least squares of relative errors",
      .x = {.title = "rings of the sensor", .scale = AxisScale::Log},
      .y = {.title = "time a scan", .scale = AxisScale::Log, .unit = "s"},
      .width = kWide,
      .height = 420};
  std::vector<std::string> methods;
  for (const RingFit& fit : study.rings) methods.push_back(fit.setting.method);
  const std::vector<std::size_t> colors = settingColors(study, methods);
  for (std::size_t k = 0; k < study.rings.size(); ++k) {
    const RingFit& fit = study.rings[k];
    const std::string& name = fit.setting.name;
    if (fit.timings.empty()) continue;
    ChartSeries dots{.name = name, .color = colors[k]};
    ChartSeries line{.name = name, .color = colors[k], .mark = ChartMark::Line};
    double least = fit.timings.front().rings, most = least;
    for (const RingTiming& t : fit.timings) {
      dots.add({static_cast<double>(t.rings), t.scanSeconds},
               fmt::format("{}\n{} rings: {}", name, t.rings, secondsText(t.scanSeconds)));
      least = std::min<double>(least, t.rings);
      most = std::max<double>(most, t.rings);
    }
    for (int i = 0; i <= kSteps; ++i) {
      const double rings = least * std::pow(most / least, static_cast<double>(i) / kSteps);
      const double seconds = fit.fixedSeconds + fit.secondsPerRing * rings;
      line.points.push_back({rings, seconds > 0 ? seconds : kNone});
    }
    chart.series.insert(chart.series.end(), {line, dots});
  }
  return chart;
}

}  // namespace

std::vector<Chart> studyCharts(const Study& study) {
  const char* const range = "range";
  const char* const incidence = "angle between beam and surface normal";
  const Groups byRange = &BeamErrors::byRange, byIncidence = &BeamErrors::byIncidence;
  return {
      frontChart(study,
                 {.name = "pareto", .title = "Speed against range error", .note = sceneNote(study), .width = 880},
                 kRangeError, frontOf(study, rangeP99)),
      frontChart(study,
                 {.name = "wrong",
                  .title = "Speed against wrong beams",
                  .note = "beams that only one of truth and setting hits, or whose class or instance differs",
                  .width = kWide},
                 kWrong, frontOf(study, wrongShare)),
      bandChart(study, {.name = "errors_by_range", .title = "Range error by range"}, range, byRange, kRangeError),
      bandChart(study, {.name = "errors_by_incidence", .title = "Range error by incidence"}, incidence, byIncidence,
                kRangeError),
      bandChart(study, {.name = "wrong_by_range", .title = "Wrong beams by range"}, range, byRange, kWrong),
      bandChart(study, {.name = "wrong_by_incidence", .title = "Wrong beams by incidence"}, incidence, byIncidence,
                kWrong),
      bandChart(study, {.name = "nearest_by_range", .title = "Distance to the nearest point, by range"}, range, byRange,
                kNearest),
      bandChart(study, {.name = "nearest_by_incidence", .title = "Distance to the nearest point, by incidence"},
                incidence, byIncidence, kNearest),
      placeChart(study, {.name = "errors_by_place", .title = "Range error at edges and away from edges"}, kRangeError),
      placeChart(study, {.name = "wrong_by_place", .title = "Wrong beams at edges and away from edges"}, kWrong),
      classChart(study, {.name = "wrong_by_class", .title = "Wrong beams by class"}, kWrong),
      classChart(study, {.name = "false_negatives_by_class", .title = "False negatives by class"}, kFalseNegatives),
      recallChart(study, {.name = "things_by_thickness", .title = "Thin things found"},
                  "smallest side of the thing's box (how many things)", &BeamErrors::byThickness),
      recallChart(study, {.name = "things_by_length", .title = "Small things found"},
                  "largest side of the thing's box (how many things)", &BeamErrors::byLength),
      stagesChart(study),
      encodingsChart(study),
      ringsChart(study)};
}

}  // namespace scanmill
