#include "report/noise/noise_report.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "charts/chart.h"
#include "config/version.h"
#include "report/page/report_html.h"

namespace scanmill {

namespace {

constexpr double kMillimetres = 1000;

ChartSeries seriesOf(std::string name, std::size_t color, ChartMark mark) {
  ChartSeries series;
  series.name = std::move(name);
  series.color = color;
  series.mark = mark;
  return series;
}

void addWithError(ChartSeries& series, double x, double y, double error, const std::string& detail) {
  series.points.push_back({x, y});
  series.spans.push_back({y - error, y + error});
  series.details.push_back(detail);
}

std::string sigmaChart(const NoiseFit& fit) {
  Chart chart;
  chart.title = "Range noise";
  chart.note = fmt::format(
      "Flat patches up to {:.0f}° from their normals; bars: standard errors of a bootstrap over patches. Without the "
      "range step of {:.3g} mm. About planes, offsets between rings, bends and the vehicle's motion add to it.",
      degrees(fit.mostIncidence), fit.step * kMillimetres);
  chart.x.title = "range (m)";
  chart.x.low = 0;
  chart.y.title = "standard deviation (mm)";
  chart.y.low = 0;
  ChartSeries measured = seriesOf("measured", 0, ChartMark::Dots);
  measured.emphasised = true;
  ChartSeries planes = seriesOf("about planes", 2, ChartMark::Dots);
  ChartSeries line = seriesOf(fit.linear ? "fitted: base + growth × range" : "fitted: table", 1, ChartMark::Line);
  for (const PatchGroup& band : fit.bands) {
    if (!band.leftOut.empty()) continue;
    addWithError(measured, band.range, band.sigma * kMillimetres, band.error * kMillimetres,
                 fmt::format("{}: {} patches", band.name, band.patches));
    planes.points.push_back({band.range, band.planeSigma * kMillimetres});
  }
  constexpr int kSteps = 60;
  const double last = fit.measuredUpTo() * 1.05;
  for (int i = 0; i <= kSteps; ++i) {
    const double range = last * i / kSteps;
    line.points.push_back({range, fit.sigmaAt(range) * kMillimetres});
  }
  chart.series = {line, planes, measured};
  return drawSvg(chart);
}

// Bars of the noise of each group.
std::string groupChart(const std::vector<PatchGroup>& groups, const std::string& title, const std::string& note,
                       const std::string& axis) {
  Chart chart;
  chart.title = title;
  chart.note = note;
  chart.x.title = axis;
  chart.y.title = "standard deviation (mm)";
  chart.y.low = 0;
  ChartSeries bars = seriesOf("measured", 0, ChartMark::Bars);
  for (const PatchGroup& group : groups) {
    chart.x.names.push_back(group.name);
    addWithError(bars, static_cast<double>(bars.points.size()), group.sigma * kMillimetres, group.error * kMillimetres,
                 fmt::format("{} patches", group.patches));
  }
  chart.series = {bars};
  return drawSvg(chart);
}

std::string incidenceChart(const NoiseFit& fit) {
  return groupChart(
      fit.incidences, "Range noise against incidence",
      "All ranges that the fit uses. The wider the beam's footprint lies along the beam, the more a rough "
      "surface spreads the ranges; steep and grazing views are of different places, too.",
      "angle between beam and normal");
}

std::string intensityChart(const NoiseFit& fit) {
  return groupChart(fit.intensities, "Range noise against intensity",
                    "Fifths of the patches that the fit uses, by the median intensity of each.",
                    "intensity, as recorded");
}

std::string dropOutChart(const NoiseFit& fit) {
  Chart chart;
  chart.title = "Drop-out";
  chart.note =
      "Beams without a return, of those whose neighbours returned from the patch's plane; bars: standard errors.";
  chart.x.title = "range (m)";
  chart.x.low = 0;
  chart.y.title = "share without a return (%)";
  chart.y.low = 0;
  ChartSeries measured = seriesOf("measured", 0, ChartMark::Dots);
  measured.emphasised = true;
  ChartSeries model = seriesOf("fitted: one share", 1, ChartMark::Line);
  for (const PatchGroup& band : fit.bands) {
    if (!band.leftOut.empty()) continue;
    addWithError(measured, band.range, 100 * band.dropOut.share(), 100 * band.dropOut.error,
                 fmt::format("{}: {} of {}", band.name, band.dropOut.lost, band.dropOut.of));
  }
  model.points = {{0, 100 * fit.dropOut.share()}, {fit.measuredUpTo() * 1.05, 100 * fit.dropOut.share()}};
  chart.series = {model, measured};
  return drawSvg(chart);
}

std::string densityChart(const NoiseFit& fit) {
  Chart chart;
  chart.title = "Point density";
  chart.note = "Medians of the patches in each band, whose angles of incidence differ from band to band.";
  chart.x.title = "range (m)";
  chart.x.scale = AxisScale::Log;
  chart.y.title = "returns per m² of surface";
  chart.y.scale = AxisScale::Log;
  ChartSeries expected = seriesOf("by the beam table", 1, ChartMark::LineAndDots);
  ChartSeries measured = seriesOf("measured", 0, ChartMark::Dots);
  measured.emphasised = true;
  for (const PatchGroup& band : fit.bands) {
    if (!band.leftOut.empty()) continue;
    expected.points.push_back({band.range, band.expectedDensity});
    measured.points.push_back({band.range, band.density});
    measured.details.push_back(fmt::format("{}: measured / expected {:.3f}", band.name, band.densityRatio));
  }
  chart.series = {expected, measured};
  return drawSvg(chart);
}

std::vector<Vec2d> histogram(const std::vector<double>& values, double reach, int bins) {
  std::vector<double> counts(static_cast<std::size_t>(bins), 0.0);
  for (const double v : values) {
    const double at = (v + reach) / (2 * reach) * bins;
    if (at >= 0 && at < bins) ++counts[static_cast<std::size_t>(at)];
  }
  std::vector<Vec2d> points;
  for (int b = 0; b < bins; ++b) {
    const double share = counts[static_cast<std::size_t>(b)] / std::max<double>(1, static_cast<double>(values.size()));
    points.push_back({(-reach + (b + 0.5) * 2 * reach / bins) * kMillimetres, 100 * share});
  }
  return points;
}

std::string residualChart(const ResidualComparison& comparison) {
  constexpr int kBins = 41;
  Chart chart;
  chart.title = fmt::format("Range residuals on patches {} from their normals", comparison.name);
  chart.note = fmt::format(
      "{} patches. Standard deviation that most patches share, the step included: recorded {:.1f} mm, simulated {:.1f} "
      "mm; about planes {:.1f} and {:.1f} mm.",
      comparison.patches, comparison.recorded.deviation * kMillimetres, comparison.simulated.deviation * kMillimetres,
      comparison.recorded.planeDeviation * kMillimetres, comparison.simulated.planeDeviation * kMillimetres);
  chart.x.title = "range beyond the surface (mm)";
  chart.y.title = "share of the returns (%)";
  chart.y.low = 0;
  const double reach = 4 * std::max(comparison.recorded.deviation, comparison.simulated.deviation);
  ChartSeries recorded = seriesOf("recorded", 0, ChartMark::Line);
  recorded.points = histogram(comparison.recorded.residuals, reach, kBins);
  ChartSeries simulated = seriesOf("simulated", 1, ChartMark::Line);
  simulated.points = histogram(comparison.simulated.residuals, reach, kBins);
  chart.series = {recorded, simulated};
  return drawSvg(chart);
}

std::string fitnessChart(const NoiseComparison& comparison) {
  Chart chart;
  chart.title = "Registration fitness between successive scans";
  chart.note =
      "Clouds of the flat patches, each moved onto the one before by the planes of both: root of the mean squared "
      "distance to the nearest point. Most of it is the beams' spacing, as the noise-free ones show.";
  chart.x.title = "pair of scans";
  chart.y.title = "root of the fitness (mm)";
  chart.y.low = 0;
  ChartSeries recorded = seriesOf("recorded", 0, ChartMark::Bars);
  ChartSeries simulated = seriesOf("simulated", 1, ChartMark::Bars);
  ChartSeries exact = seriesOf("simulated without effects", 2, ChartMark::Bars);
  for (const FitnessComparison& pair : comparison.fitness) {
    const double x = static_cast<double>(chart.x.names.size());
    chart.x.names.push_back(pair.pair);
    const auto add = [&](ChartSeries& series, const std::optional<double>& fitness) {
      if (fitness) series.points.push_back({x, std::sqrt(*fitness) * kMillimetres});
    };
    add(recorded, pair.recorded);
    add(simulated, pair.simulated);
    add(exact, pair.exact);
  }
  chart.series = {recorded, simulated, exact};
  return drawSvg(chart);
}

std::string millimetres(double metres) {
  return fmt::format("{:.2f}", metres * kMillimetres);
}

std::string tableOf(const std::vector<PatchGroup>& groups, const std::string& first) {
  HtmlTable table;
  table.column(first);
  table.column("left out", "why the fit does not use it");
  table.column("range (m)", "mean");
  table.column("patches");
  table.column("sigma (mm)", "standard deviation of the range, the step left out, and its standard error");
  table.column("with step", "mm, the range's rounding to its step included");
  table.column("about planes", "mm, offsets between rings, bends and motion included, the step left out");
  table.column("spread", "of the patches' own deviations over what equal ones would have");
  table.column("drop-out (%)", "beams without a return, of those whose neighbours returned from the plane");
  table.column("points/m²");
  table.column("expected", "by the beam table: points/m² / ratio");
  table.column("ratio", "measured / expected, median of the patches' own");
  for (const PatchGroup& g : groups) {
    const auto measured = [](bool any, std::string text, double value, std::string hint = {}) {
      return any ? HtmlCell{std::move(text), value, std::move(hint)} : HtmlCell{"-"};
    };
    const bool any = g.patches > 0;
    table.row(
        {{g.name, g.low},
         {g.leftOut},
         measured(any, fmt::format("{:.1f}", g.range), g.range),
         {std::to_string(g.patches), static_cast<double>(g.patches), fmt::format("{} points", g.points)},
         measured(any, millimetres(g.sigma) + " ± " + millimetres(g.error), g.sigma),
         measured(any, millimetres(g.withStep), g.withStep),
         measured(any, millimetres(g.planeSigma), g.planeSigma),
         measured(any, fmt::format("{:.2f}", g.unevenness), g.unevenness),
         measured(g.dropOut.of > 0, fmt::format("{:.2f} ± {:.2f}", 100 * g.dropOut.share(), 100 * g.dropOut.error),
                  g.dropOut.share(), fmt::format("{} of {}", g.dropOut.lost, g.dropOut.of)),
         measured(g.density > 0, fmt::format("{:.0f}", g.density), g.density),
         measured(g.density > 0, fmt::format("{:.0f}", g.expectedDensity), g.expectedDensity),
         measured(g.density > 0, fmt::format("{:.3f}", g.densityRatio), g.densityRatio)},
        g.leftOut.empty());
  }
  return table.html();
}

HtmlCell motionCell(const PlaneMotion& motion) {
  const Vec3d& t = motion.targetFromSource.translation;
  const std::string hint =
      fmt::format("[{:.3f}, {:.3f}, {:.3f}] m, {} patches on planes", t.x, t.y, t.z, motion.matched);
  if (!motion.failure.empty()) return {"did not converge: " + motion.failure, INFINITY, hint};
  return {fmt::format("{:.3f} ± {:.3f}", length(t), motion.error), length(t), hint};
}

std::string fitnessTableText(const NoiseComparison& comparison) {
  HtmlTable table;
  for (const char* title : {"pair", "recorded motion (m)", "simulated motion (m)", "recorded (m²)", "simulated (m²)",
                            "simulated without effects (m²)"}) {
    table.column(title);
  }
  const auto cell = [](const std::optional<double>& value) {
    return value ? HtmlCell{fmt::format("{:.6f}", *value), *value} : HtmlCell{"-"};
  };
  for (const FitnessComparison& p : comparison.fitness) {
    table.row({{p.pair},
               motionCell(p.recordedMotion),
               motionCell(p.simulatedMotion),
               cell(p.recorded),
               cell(p.simulated),
               cell(p.exact)});
  }
  return htmlParagraph(
             "How the sensor moved between two scans is found by matching their flat patches plane on plane, not point "
             "on point: the beams' rings move with the sensor and would hold it still. The search starts from all "
             "horizontal shifts up to 3 m. The clouds are moved so, and not registered any further; where a motion did "
             "not converge there is no fitness.") +
         table.html();
}

}  // namespace

std::vector<NoiseChart> noiseCharts(const NoiseFit& fit, const NoiseComparison& comparison) {
  std::vector<NoiseChart> charts{{"range_noise", sigmaChart(fit)},
                                 {"drop_out", dropOutChart(fit)},
                                 {"density", densityChart(fit)},
                                 {"incidence", incidenceChart(fit)}};
  for (const ResidualComparison& c : comparison.residuals) {
    charts.push_back({fmt::format("residuals_{}", charts.size() - 3), residualChart(c)});
  }
  if (!comparison.fitness.empty()) charts.push_back({"fitness", fitnessChart(comparison)});
  return charts;
}

std::string noiseReport(const NoiseFit& fit, const NoiseComparison& comparison, const std::string& sensor,
                        const std::string& effects, const std::string& date) {
  const std::string head = htmlParagraph(
      fmt::format("Measured on {}, {}, by Scanmill {}. {} of {} beams returned ({:.1f} %). Range step: {}.",
                  fmt::join(fit.files, ", "), date, kVersion, fit.returns, fit.beams,
                  100.0 * static_cast<double>(fit.returns) / static_cast<double>(std::max<std::uint64_t>(1, fit.beams)),
                  fit.step > 0 ? fmt::format("{:.3g} mm", fit.step * kMillimetres) : "none found"));
  std::string beyond;
  for (const std::string& line : beyondMeasured(fit)) beyond += " " + line;
  std::vector<std::string> residuals;
  for (const ResidualComparison& c : comparison.residuals) residuals.push_back(residualChart(c));
  std::vector<HtmlSection> sections{
      {"model", "The model",
       "What the sensor's file says from now on, and pipelines take by `effects: sensor`." + beyond, htmlCode(effects)},
      {"range", "By range",
       fmt::format(
           "A flat patch is {} rings by {} columns of neighbouring beams, coloured like a chessboard: one colour "
           "is tested for lying on a plane, the other is measured, so that the choice of the patches does not "
           "change what is measured. Highlighted rows are what the fit uses.",
           kPatchRings, kPatchColumns),
       htmlFigures({sigmaChart(fit), dropOutChart(fit), densityChart(fit)}) + tableOf(fit.bands, "range")},
      {"incidence", "By incidence",
       "Patches at the ranges that the fit uses. The rows' mean ranges differ, too: noise that grows from row to row "
       "may "
       "be that of the range.",
       htmlFigures({incidenceChart(fit)}) + tableOf(fit.incidences, "incidence")},
      {"intensity", "By intensity", "",
       fit.intensities.empty() ? std::string()
                               : htmlFigures({intensityChart(fit)}) + tableOf(fit.intensities, "intensity")},
      {"simulated", "Recorded and simulated",
       "The planes of the same patches, seen by the same beams, with the effects above.",
       htmlFigures(residuals) + (comparison.fitness.empty()
                                     ? std::string()
                                     : htmlFigures({fitnessChart(comparison)}) + fitnessTableText(comparison))}};
  return htmlPage(fmt::format("Noise of {}", sensor), head, sections);
}

}  // namespace scanmill
