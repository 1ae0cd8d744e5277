#include "report/noise/noise_report.h"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "charts/chart.h"
#include "config/version.h"
#include "report/page/page.h"

namespace scanmill {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PatchGroup, name, leftOut, patches, points, range, sigma, error, withStep,
                                   planeSigma, unevenness)

namespace {

constexpr double kMillimetres = 1000;

void addWithError(ChartSeries& series, double x, double y, double error, const std::string& detail) {
  series.add({x, y}, detail);
  series.spans.push_back({y - error, y + error});
}

Chart sigmaChart(const NoiseFit& fit) {
  Chart chart{.name = "range_noise", .title = "Range noise"};
  chart.note = fmt::format(
      "Flat patches up to {:.0f}° from their normals; bars: standard errors of a bootstrap over patches. The range "
      "step of {:.3g} mm is not included. The deviation about planes also includes offsets between rings, curvature "
      "and the vehicle's motion.",
      degrees(fit.mostIncidence), fit.step * kMillimetres);
  chart.x = {.title = "range (m)", .low = 0};
  chart.y = {.title = "standard deviation (mm)", .low = 0};
  ChartSeries measured{.name = "measured", .color = 0, .mark = ChartMark::Dots, .emphasised = true};
  ChartSeries planes{.name = "about planes", .color = 2, .mark = ChartMark::Dots};
  ChartSeries line{
      .name = fit.linear ? "fitted: base + growth × range" : "fitted: table", .color = 1, .mark = ChartMark::Line};
  for (const PatchGroup* band : fit.used()) {
    addWithError(measured, band->range, band->sigma * kMillimetres, band->error * kMillimetres,
                 fmt::format("{}: {} patches", band->name, band->patches));
    planes.points.push_back({band->range, band->planeSigma * kMillimetres});
  }
  constexpr int kSteps = 60;
  const double last = fit.measuredUpTo() * 1.05;
  for (int i = 0; i <= kSteps; ++i) {
    const double range = last * i / kSteps;
    line.points.push_back({range, fit.sigmaAt(range) * kMillimetres});
  }
  chart.series = {line, planes, measured};
  return chart;
}

// Returns `chart` with a bar for the noise of each group.
Chart groupChart(const std::vector<PatchGroup>& groups, Chart chart) {
  chart.y = {.title = "standard deviation (mm)", .low = 0};
  ChartSeries bars{.name = "measured", .color = 0, .mark = ChartMark::Bars};
  for (const PatchGroup& group : groups) {
    chart.x.names.push_back(group.name);
    addWithError(bars, static_cast<double>(bars.points.size()), group.sigma * kMillimetres, group.error * kMillimetres,
                 fmt::format("{} patches", group.patches));
  }
  chart.series = {bars};
  return chart;
}

Chart incidenceChart(const NoiseFit& fit) {
  return groupChart(fit.incidences, {.name = "incidence",
                                     .title = "Range noise against incidence",
                                     .note = "All ranges that the fit uses. At grazing incidence the footprint extends "
                                             "along the beam, so that a rough surface spreads the ranges more; the "
                                             "rows also show different places.",
                                     .x = {.title = "angle between beam and normal"}});
}

Chart intensityChart(const NoiseFit& fit) {
  return groupChart(fit.intensities, {.name = "intensity",
                                      .title = "Range noise against intensity",
                                      .note = "The patches that the fit uses, in five groups of equal number by their "
                                              "median intensity.",
                                      .x = {.title = "intensity, as recorded"}});
}

Chart dropOutChart(const NoiseFit& fit) {
  Chart chart{.name = "drop_out", .title = "Drop-out"};
  chart.note =
      "Share of beams without a return among those whose neighbours returned from the patch's plane; bars: standard "
      "errors.";
  chart.x = {.title = "range (m)", .low = 0};
  chart.y = {.title = "share without a return (%)", .low = 0};
  ChartSeries measured{.name = "measured", .color = 0, .mark = ChartMark::Dots, .emphasised = true};
  ChartSeries model{.name = "fitted: one share", .color = 1, .mark = ChartMark::Line};
  for (const PatchGroup* band : fit.used()) {
    addWithError(measured, band->range, 100 * band->dropOut.share(), 100 * band->dropOut.error,
                 fmt::format("{}: {} of {}", band->name, band->dropOut.lost, band->dropOut.of));
  }
  model.points = {{0, 100 * fit.dropOut.share()}, {fit.measuredUpTo() * 1.05, 100 * fit.dropOut.share()}};
  chart.series = {model, measured};
  return chart;
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

Chart residualChart(const ResidualComparison& comparison) {
  constexpr int kBins = 41;
  Chart chart;
  chart.title = fmt::format("Range residuals on patches {} from their normals", comparison.name);
  chart.note = fmt::format(
      "{} patches. Typical standard deviation of a patch, with the step: recorded {:.1f} mm, simulated {:.1f} mm; "
      "about planes {:.1f} and {:.1f} mm.",
      comparison.patches, comparison.recorded.deviation * kMillimetres, comparison.simulated.deviation * kMillimetres,
      comparison.recorded.planeDeviation * kMillimetres, comparison.simulated.planeDeviation * kMillimetres);
  chart.x.title = "range beyond the surface (mm)";
  chart.y = {.title = "share of the returns (%)", .low = 0};
  const double reach = 4 * std::max(comparison.recorded.deviation, comparison.simulated.deviation);
  ChartSeries recorded{.name = "recorded", .color = 0, .mark = ChartMark::Line};
  recorded.points = histogram(comparison.recorded.residuals, reach, kBins);
  ChartSeries simulated{.name = "simulated", .color = 1, .mark = ChartMark::Line};
  simulated.points = histogram(comparison.simulated.residuals, reach, kBins);
  chart.series = {recorded, simulated};
  return chart;
}

// Returns the table rows of the groups. `by`: kind of the groups. Rows of groups without patches have no figures.
Json groupsJson(const std::vector<PatchGroup>& groups, const char* by) {
  Json rows = Json::array();
  for (const PatchGroup& g : groups) {
    Json row = g;
    row["strong"] = g.leftOut.empty();
    if (g.patches == 0) {
      for (const char* key : {"range", "sigma", "error", "withStep", "planeSigma", "unevenness"}) row.erase(key);
    }
    if (g.dropOut.of > 0) {
      row.update({{"drop_out", 100 * g.dropOut.share()},
                  {"drop_out_error", 100 * g.dropOut.error},
                  {"lost", g.dropOut.lost},
                  {"of", g.dropOut.of}});
    }
    rows.push_back(std::move(row));
  }
  return {{"by", by}, {"rows", std::move(rows)}};
}

}  // namespace

std::vector<Chart> noiseCharts(const NoiseFit& fit, const std::vector<ResidualComparison>& comparison) {
  std::vector<Chart> charts{sigmaChart(fit), dropOutChart(fit), incidenceChart(fit)};
  for (const ResidualComparison& c : comparison) {
    charts.push_back(residualChart(c));
    charts.back().name = fmt::format("residuals_{}", charts.size() - 3);
  }
  return charts;
}

std::string noiseReport(const NoiseFit& fit, const std::vector<ResidualComparison>& comparison,
                        const std::string& sensor, const std::string& effects, const std::string& date) {
  const auto beams = static_cast<double>(std::max<std::uint64_t>(1, fit.beams));
  Json page{{"title", "Noise of " + sensor},
            {"files", fit.files},
            {"date", date},
            {"version", kVersion},
            {"returns", fit.returns},
            {"beams", fit.beams},
            {"percent", 100 * static_cast<double>(fit.returns) / beams},
            {"beyond", beyondMeasured(fit)},
            {"effects", effects},
            {"patch_rings", kPatchRings},
            {"patch_columns", kPatchColumns},
            {"bands", groupsJson(fit.bands, "range")},
            {"incidences", groupsJson(fit.incidences, "incidence")},
            {"intensities", groupsJson(fit.intensities, "intensity")}};
  if (fit.step > 0) page["step_mm"] = kMillimetres * fit.step;
  page["charts"] = chartValues(noiseCharts(fit, comparison));
  page["charts"]["intensity"] = chartValues(intensityChart(fit));
  for (const ResidualComparison& c : comparison) page["residuals"].push_back(chartValues(residualChart(c)));
  return fillPage(kNoiseTemplate, std::move(page));
}

}  // namespace scanmill
