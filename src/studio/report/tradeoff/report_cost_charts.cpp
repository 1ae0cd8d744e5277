#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "charts/chart.h"
#include "report/tradeoff/report_charts.h"
#include "report/tradeoff/report_figures.h"
#include "study/figure_text.h"

namespace scanmill {

namespace {

constexpr double kSmallStage = 0.03;  // of a scan's time: less joins the rest
const std::string kRest = "the rest";
constexpr std::array<std::size_t, 7> kBarColors{0, 1, 2, 3, 4, 5, 7};

// By stage, of a scan's time.
std::map<std::string, double> sharesOfStages(const Cost& cost) {
  if (cost.stages.empty() || cost.scanSeconds <= 0) return {{"trace", 1}};
  double sum = 0;
  for (const auto& [stage, seconds] : cost.stages) sum += seconds;
  std::map<std::string, double> shares = cost.stages;
  for (auto& [stage, seconds] : shares) seconds /= std::max(sum, cost.scanSeconds);
  return shares;
}

// Those that matter to any of the settings, and the rest.
std::vector<std::string> stagesOf(const Study& study, const std::vector<std::size_t>& settings) {
  std::vector<std::string> stages;
  for (const std::size_t i : settings) {
    for (const auto& [stage, share] : sharesOfStages(study.settings[i].measured.cost)) {
      const bool known = std::find(stages.begin(), stages.end(), stage) != stages.end();
      if (share >= kSmallStage && !known) stages.push_back(stage);
    }
  }
  stages.push_back(kRest);
  return stages;
}

}  // namespace

std::string stagesChart(const Study& study) {
  const std::vector<std::size_t> rows = settingsByMethod(study, kReportRows);
  if (rows.empty()) return "";
  Chart chart{.title = "Where a scan's time goes",
              .note =
                  "median time of a scan, split as the method accounts for it; stages that run on several threads "
                  "at once share the time by what each takes in all"};
  chart.x = {.title = "time a scan", .unit = "s"};
  chart.stacked = true;
  const std::vector<std::string> stages = stagesOf(study, rows);
  for (const std::size_t i : rows) chart.y.names.push_back(study.settings[i].setting.name);
  for (std::size_t k = 0; k < stages.size(); ++k) {
    ChartSeries series{.name = wordsOf(stages[k]),
                       .color = stages[k] == kRest ? 6 : kBarColors[k % kBarColors.size()],
                       .mark = ChartMark::Bars};
    for (std::size_t row = 0; row < rows.size(); ++row) {
      const Cost& cost = study.settings[rows[row]].measured.cost;
      const std::map<std::string, double> own = sharesOfStages(cost);
      double seconds = cost.scanSeconds;
      if (stages[k] == kRest) {
        for (const std::string& stage : stages) seconds -= own.contains(stage) ? own.at(stage) * cost.scanSeconds : 0;
        seconds = std::max(seconds, 0.0);
      } else {
        seconds *= own.contains(stages[k]) ? own.at(stages[k]) : 0;
      }
      series.points.push_back({seconds, static_cast<double>(row)});
      series.labels.push_back(k + 1 == stages.size() ? secondsText(cost.scanSeconds) : "");
      series.details.push_back(fmt::format("{}\n{}: {} of {}", chart.y.names[row], stages[k], secondsText(seconds),
                                           secondsText(cost.scanSeconds)));
    }
    chart.series.push_back(std::move(series));
  }
  chart.width = kReportWidth;
  chart.height = 130 + 22 * static_cast<int>(rows.size());
  return drawSvg(chart);
}

std::string encodingsChart(const Study& study) {
  Chart chart{.title = "Encodings: size against speed",
              .note = "one thread; beside each the largest error of a position, measured by decoding"};
  chart.x = {.title = "bytes a point (to the left is better)", .scale = AxisScale::Log};
  chart.y = {.title = "points encoded a second (higher is better)", .scale = AxisScale::Log};
  chart.height = 420;
  chart.width = kReportWidth;
  std::vector<std::string> formats;
  for (const EncodingResult& e : study.encodings) {
    if (!e.failure.empty()) continue;
    auto at = std::find(formats.begin(), formats.end(), e.format);
    if (at == formats.end()) {
      at = formats.insert(formats.end(), e.format);
      chart.series.push_back({.name = e.format, .color = (formats.size() - 1) % 7});
    }
    ChartSeries& series = chart.series[static_cast<std::size_t>(at - formats.begin())];
    const std::string error = e.largestError == 0 ? "no error" : metresText(e.largestError);
    series.points.push_back({e.bytesPerPoint, e.encodePointsPerSecond});
    series.labels.push_back(fmt::format("{}: {}", e.name, error));
    series.details.push_back(fmt::format("{}\n{:.2f} bytes a point, {} points/s encoded, {} points/s decoded\n{}",
                                         e.name, e.bytesPerPoint, amountText(e.encodePointsPerSecond),
                                         amountText(e.decodePointsPerSecond), error));
  }
  return chart.series.empty() ? "" : drawSvg(chart);
}

std::string ringsChart(const Study& study) {
  Chart chart{
      .title = "Time a scan against rings",
      .note = "dots: measured; lines: a fixed cost and a cost per ring, fitted by least squares of relative errors"};
  chart.x = {.title = "rings of the sensor", .scale = AxisScale::Log};
  chart.y = {.title = "time a scan", .scale = AxisScale::Log, .unit = "s"};
  chart.width = kReportWidth;
  chart.height = 420;
  std::vector<std::pair<std::string, const RingFit*>> fits;
  for (const RingFit& f : study.rings) fits.emplace_back(f.setting.name, &f);
  if (study.showing) fits.emplace_back("drawing a picture of the scan", &*study.showing);
  // What has no method is not a method's colour.
  std::vector<std::string> methods;
  methods.reserve(fits.size());
  for (const auto& entry : fits) methods.push_back(entry.second->setting.method);
  const std::vector<std::size_t> colors = settingColors(study, methods);
  for (std::size_t k = 0; k < fits.size(); ++k) {
    const auto& [name, fit] = fits[k];
    if (fit->timings.empty()) continue;
    ChartSeries dots{.name = name, .color = colors[k]};
    double least = fit->timings.front().rings, most = least;
    for (const RingTiming& t : fit->timings) {
      dots.points.push_back({static_cast<double>(t.rings), t.scanSeconds});
      dots.details.push_back(fmt::format("{}\n{} rings: {}", name, t.rings, secondsText(t.scanSeconds)));
      least = std::min<double>(least, t.rings);
      most = std::max<double>(most, t.rings);
    }
    ChartSeries line{.name = name, .color = colors[k], .mark = ChartMark::Line};
    constexpr int kSteps = 48;
    for (int i = 0; i <= kSteps; ++i) {
      const double rings = least * std::pow(most / least, static_cast<double>(i) / kSteps);
      const double seconds = fit->fixedSeconds + fit->secondsPerRing * rings;
      line.points.push_back({rings, seconds > 0 ? seconds : std::numeric_limits<double>::quiet_NaN()});
    }
    chart.series.push_back(std::move(line));
    chart.series.push_back(std::move(dots));
  }
  return chart.series.empty() ? "" : drawSvg(chart);
}

}  // namespace scanmill
