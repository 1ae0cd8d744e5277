#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/short_text.h"
#include "report/page/page.h"
#include "report/tradeoff/report.h"
#include "study/figure_text.h"
#include "study/tradeoff/study.h"
#include "viewer/color_map.h"
#include "viewer/picture.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostLines = 6;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// A measure of error that charts show on a logarithmic axis.
struct Measure {
  const char* title;
  const char* unit;                              // "m" or "%"
  std::function<double(const GroupErrors&)> of;  // returns the error in metres, or as a fraction

  ChartAxis axis(const char* titleEnd = "") const {
    return {.title = std::string(title) + titleEnd,
            .scale = AxisScale::Log,
            .unit = unit,
            .zero = *unit == 'm' ? "exact" : "none"};
  }
  std::string text(double value) const {
    return *unit != 'm' ? shareText(value) : value == 0 ? "exact" : metresText(value);
  }
};

const Measure kRangeError{"p99 of the range error: 99 % of the beams have less", "m", rangeP99};
const Measure kNearest{"mean distance from true points to the nearest of the setting", "m", [](const GroupErrors& e) {
                         return e.nearestTo.count == 0 ? kNone : e.nearestTo.mean < kExactRange ? 0 : e.nearestTo.mean;
                       }};
const Measure kWrong{"false negatives, false positives and wrongly labelled beams", "%",
                     [](const GroupErrors& e) { return e.beams == 0 ? kNone : wrongShare(e); }};

const BeamErrors& errorsOf(const Study& study, std::size_t setting) {
  return study.settings[setting].measured.errors;
}

// Returns the lines that are shown when the mouse points at a setting's mark.
std::string settingDetail(const Study& study, const SettingResult& s) {
  const GroupErrors& e = s.measured.errors.all;
  return fmt::format(
      "{}\n{} beams/s, {} a scan\nrange error: median {}, p99 {}\nlabels {}, false negatives or positives {}",
      s.setting.name, shortNumber(beamsPerSecond(study, s)), secondsText(s.measured.cost.scanSeconds),
      metresText(e.range.median), metresText(e.range.p99), shareText(e.labels()), shareText(e.missRate()));
}

// Returns the part of a setting's or encoding's name after `owner`, its method or format: the options, such as
// "resolution=512". If the name does not start with `owner` and a space, returns the name as words.
std::string optionsIn(const std::string& name, const std::string& owner) {
  return name.starts_with(owner + " ") ? name.substr(owner.size() + 1) : keyAsWords(name);
}

std::string sceneNote(const Study& study) {
  return fmt::format("{}; {}; {}, {}", study.scene.key.empty() ? study.pipelineName : study.scene.key,
                     fmt::join(study.sensors, "; "), study.machine.processor,
                     pluralOf(static_cast<std::uint64_t>(study.machine.threads), "thread"));
}

// Returns the Pareto front as a staircase line. `front`: points (beams per second, error) on the front, the fastest
// first. `all`: all points, which determine the ends of the line.
ChartSeries frontLine(const std::vector<Vec2d>& front, const std::vector<Vec2d>& all) {
  ChartSeries line{.name = "Pareto front: no setting is both faster and better",
                   .color = 6,
                   .mark = ChartMark::Line,
                   .emphasised = true};
  double slowest = front.front().x, error = front.front().y;
  for (const Vec2d& p : all) {
    if (p.x > 0) slowest = std::min(slowest, p.x);
    error = std::max(error, p.y);
  }
  for (const Vec2d& p : front) {
    line.points.insert(line.points.end(), {{p.x, error}, p});
    error = p.y;
  }
  line.points.push_back({slowest, error});
  return line;
}

// Returns `chart` with a mark for each measured setting and emphasised marks for the settings on the Pareto front.
// `front`: indices of these settings in Study::settings.
Chart frontChart(const Study& study, Chart chart, const Measure& measure, const std::vector<std::size_t>& front) {
  chart.x = {.title = "beams per second (right is better)", .scale = AxisScale::Log};
  chart.y = measure.axis(" (lower is better)");
  chart.height = 560;
  const std::vector<std::size_t> measured = measuredSettings(study);
  std::vector<Vec2d> allPoints, frontPoints;
  const auto pointOf = [&](std::size_t i) {
    return Vec2d{beamsPerSecond(study, study.settings[i]), measure.of(errorsOf(study, i).all)};
  };
  for (const std::size_t i : measured) {
    if (std::isfinite(pointOf(i).y)) allPoints.push_back(pointOf(i));
  }
  for (const std::size_t i : front) frontPoints.push_back(pointOf(i));
  if (!frontPoints.empty()) chart.series.push_back(frontLine(frontPoints, allPoints));
  for (const bool isOnFront : {true, false}) {
    for (const std::string& method : methodsOf(study)) {
      ChartSeries byDefault{.name = keyAsWords(method), .color = methodColor(method), .emphasised = isOnFront};
      ChartSeries others = byDefault;
      byDefault.labelsFirst = true;
      for (const std::size_t i : measured) {
        const SettingResult& s = study.settings[i];
        if (s.setting.method != method || (std::ranges::find(front, i) != front.end()) != isOnFront) continue;
        ChartSeries& series = isDefault(s.setting) ? byDefault : others;
        series.add(pointOf(i), settingDetail(study, s));
        series.labels.push_back(optionsIn(s.setting.name, s.setting.method));
      }
      chart.series.insert(chart.series.end(), {byDefault, others});
    }
  }
  return chart;
}

// Returns the y value of a setting's mark, NaN for no mark, and the text of the mark. `errors`: the setting's errors.
// `name`: index of the mark in ChartAxis::names of the x axis.
using Figure = std::function<std::pair<double, std::string>(const BeamErrors& errors, std::size_t name)>;

// Returns `chart` with one series per setting. A series has one mark for each name on the x axis; the marks for the
// same name are drawn side by side. `settings`: indices in Study::settings.
Chart settingsChart(const Study& study, const std::vector<std::size_t>& settings, Chart chart, const Figure& figure) {
  constexpr double kBeside = 0.09;  // distance between marks for the same name; names are 1 apart
  chart.width = kHalfWidth;
  std::vector<std::string> methods;
  for (const std::size_t i : settings) methods.push_back(study.settings[i].setting.method);
  const std::vector<std::size_t> colors = settingColors(methods);
  const double middle = (static_cast<double>(settings.size()) - 1) / 2;
  for (std::size_t k = 0; k < settings.size(); ++k) {
    const std::string& name = study.settings[settings[k]].setting.name;
    ChartSeries series{.name = name, .color = colors[k], .mark = ChartMark::LineAndDots};
    for (std::size_t n = 0; n < chart.x.names.size(); ++n) {
      const auto [value, detail] = figure(errorsOf(study, settings[k]), n);
      series.add({static_cast<double>(n) + (static_cast<double>(k) - middle) * kBeside, value}, name + "\n" + detail);
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

// Returns `chart` with a line for each shown setting: the error in each group of beams. `bands`: title of the x axis.
Chart bandChart(const Study& study, Chart chart, const char* bands, GroupsOfErrors groups, const Measure& measure) {
  const std::vector<std::size_t> settings = shownSettings(study, kMostLines);
  const std::vector<std::string> names = groupNames(study, settings, groups);
  chart.x = {.title = bands, .names = names};
  chart.y = measure.axis();
  chart.height = 400;
  return settingsChart(study, settings, std::move(chart), [&](const BeamErrors& errors, std::size_t n) {
    const GroupErrors* const group = errorsNamed(errors.*groups, names[n]);
    const double value = group == nullptr ? kNone : measure.of(*group);
    return std::pair(value, fmt::format("{}: {}", names[n], measure.text(value)));
  });
}

// Returns `chart` with a line per shown setting: the share of objects found, by size. `sizes`: title of the x axis.
Chart recallChart(const Study& study, Chart chart, const char* sizes, std::vector<SizeRecall> BeamErrors::*recall) {
  const std::vector<std::size_t> settings = shownSettings(study, kMostLines);
  chart.note = "share of the things with a true hit that at least one beam hits";
  chart.x.title = sizes;
  chart.y = {.title = "things found", .unit = "%", .high = 1};
  chart.height = 390;
  std::vector<std::size_t> bands;  // bands with instances; the same for all settings
  for (std::size_t b = 0; !settings.empty() && b < (errorsOf(study, settings[0]).*recall).size(); ++b) {
    const SizeRecall& band = (errorsOf(study, settings[0]).*recall)[b];
    if (band.instances == 0) continue;
    bands.push_back(b);
    chart.x.names.push_back(fmt::format("{} ({})", band.name, band.instances));
  }
  return settingsChart(study, settings, std::move(chart), [&](const BeamErrors& errors, std::size_t n) {
    const std::vector<SizeRecall>& sizeBands = errors.*recall;
    const SizeRecall band = bands[n] < sizeBands.size() ? sizeBands[bands[n]] : SizeRecall{};
    return std::pair(shareOf(band.instancesFound, band.instances, kNone),
                     fmt::format("{}: {} of {} things, {} of {} beams", band.name, band.instancesFound, band.instances,
                                 band.beamsFound, band.beams));
  });
}

Chart encodingsChart(const Study& study) {
  Chart chart{.name = "encodings",
              .title = "Encodings: size against speed",
              .note = "one thread; labels: the largest error of a position, measured by decoding",
              .x = {.title = "bytes per point (left is better)", .scale = AxisScale::Log},
              .y = {.title = "points encoded per second (higher is better)", .scale = AxisScale::Log},
              .width = kWholeWidth,
              .height = 420};
  for (const EncodingResult& e : study.encodings) {
    if (!e.failure.empty()) continue;
    auto series = std::ranges::find_if(chart.series, [&](const ChartSeries& s) { return s.name == e.format; });
    if (series == chart.series.end()) {
      series = chart.series.insert(series, {.name = e.format, .color = chart.series.size() % 7});
    }
    const std::string error = e.largestError == 0 ? "no error" : metresText(e.largestError);
    series->labels.push_back(fmt::format("{}: {}", optionsIn(e.name, e.format), error));
    series->add(
        {e.bytesPerPoint, e.encodePointsPerSecond},
        fmt::format("{}\n{:.2f} bytes a point, {} points/s encoded, {} points/s decoded\n{}", e.name, e.bytesPerPoint,
                    shortNumber(e.encodePointsPerSecond), shortNumber(e.decodePointsPerSecond), error));
  }
  return chart;
}

constexpr double kLeastError = 1e-3;  // errors below this bound (m) get the same colour
constexpr double kDecades = 3;        // number of decades of error that the colour map covers
constexpr Rgb kFalseNegativeColor{255, 70, 70};
constexpr Rgb kFalsePositiveColor{255, 255, 255};
constexpr Rgb kOtherLabelColor{255, 150, 220};

Rgb errorColor(double error) {
  // Fraction of the colour map that is not used: its dark end, whose colours can hardly be seen.
  constexpr double kDarkest = 0.15;
  return viridis(kDarkest + (1 - kDarkest) * std::log10(std::max(error, kLeastError) / kLeastError) / kDecades);
}

}  // namespace

std::vector<Chart> studyCharts(const Study& study) {
  const char* const range = "range";
  const char* const incidence = "angle between beam and surface normal";
  const GroupsOfErrors byRange = &BeamErrors::byRange, byIncidence = &BeamErrors::byIncidence;
  return {frontChart(study,
                     {.name = "pareto", .title = "Speed against range error", .note = sceneNote(study), .width = 880},
                     kRangeError, frontOf(study, rangeP99)),
          frontChart(study,
                     {.name = "wrong",
                      .title = "Speed against wrong beams",
                      .note = "beams that only one of truth and setting hits, or whose class or instance differs",
                      .width = kWholeWidth},
                     kWrong, frontOf(study, wrongShare)),
          bandChart(study, {.name = "errors_by_range", .title = "Range error by range"}, range, byRange, kRangeError),
          bandChart(study, {.name = "errors_by_incidence", .title = "Range error by incidence"}, incidence, byIncidence,
                    kRangeError),
          bandChart(study, {.name = "wrong_by_range", .title = "Wrong beams by range"}, range, byRange, kWrong),
          bandChart(study, {.name = "wrong_by_incidence", .title = "Wrong beams by incidence"}, incidence, byIncidence,
                    kWrong),
          bandChart(study, {.name = "nearest_by_range", .title = "Distance to the nearest point, by range"}, range,
                    byRange, kNearest),
          bandChart(study, {.name = "nearest_by_incidence", .title = "Distance to the nearest point, by incidence"},
                    incidence, byIncidence, kNearest),
          recallChart(study, {.name = "things_by_thickness", .title = "Thin things found"},
                      "smallest side of the thing's box (how many things)", &BeamErrors::byThickness),
          recallChart(study, {.name = "things_by_length", .title = "Small things found"},
                      "largest side of the thing's box (how many things)", &BeamErrors::byLength),
          encodingsChart(study)};
}

std::string drawErrors(const TrueShot& truth, const Hits& tested) {
  const Hits& real = truth.truth.hits;
  Scan scan;
  scan.rings = real.rings;
  scan.columns = real.columns;
  Coloring coloring;
  // Adds the point at a range (m) along a beam to `scan`, and its colour to `coloring`.
  const auto addPoint = [&](std::size_t beam, double range, const Rgb& color) {
    scan.position.push_back(Vec3f(truth.shot.beams->originOf(beam) + truth.shot.beams->direction[beam] * range));
    coloring.colors.push_back(color);
  };
  for (std::size_t i = 0; i < real.size(); ++i) {
    if (!real.hit(i) && !tested.hit(i)) continue;
    if (!tested.hit(i)) {
      addPoint(i, truth.truth.range[i], kFalseNegativeColor);
    } else if (!real.hit(i)) {
      addPoint(i, double{tested.range[i]}, kFalsePositiveColor);
    } else if (real.semantic[i] != tested.semantic[i] || real.instance[i] != tested.instance[i]) {
      addPoint(i, truth.truth.range[i], kOtherLabelColor);
    } else {
      addPoint(i, truth.truth.range[i], errorColor(std::abs(double{tested.range[i]} - truth.truth.range[i])));
    }
  }
  coloring.legend.title = "range error";
  for (const auto& [name, error] :
       {std::pair{"1 mm or less", 1e-3}, {"1 cm", 1e-2}, {"10 cm", 0.1}, {"1 m or more", 1.0}}) {
    coloring.legend.entries.push_back({name, errorColor(error)});
  }
  for (const auto& [name, color] : {std::pair{"other label", kOtherLabelColor},
                                    {"false negatives", kFalseNegativeColor},
                                    {"false positives", kFalsePositiveColor}}) {
    coloring.legend.entries.push_back({fmt::format("{}: {}", name, std::ranges::count(coloring.colors, color)), color});
  }
  const std::string title = fmt::format("{}, {}", truth.shot.sample, truth.shot.sensorName);
  return encodePng(drawScan(scan, coloring, 1200, 675, title, false));
}

}  // namespace scanmill
