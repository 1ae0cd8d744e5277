#include "report/repeatability/repeatability_report.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>

#include "base/append_new.h"
#include "report/page/page.h"

namespace scanmill {

namespace {

// Removes the key `deviation` if there are at most two pairs: both consist of the same two scans, in either direction.
void dropDeviationOfTwo(Json& spread) {
  if (!spread.is_null() && spread["pairs"] < 3) spread.erase("deviation");
}

// Completes the JSON of one pose for the page's tables: adds the figures of the reference level to `pose` itself, and a
// row for each source level to pose["sources"].
void addTableRows(Json& pose, const Repeatability& result) {
  const std::size_t count = result.levels.size(), reference = result.reference;
  Json& fitness = pose["fitness_m2"];  // one cell for each pair of levels, by source and target
  for (Json& cell : fitness) {
    dropDeviationOfTwo(cell["registered"]);
    dropDeviationOfTwo(cell["unmoved"]);
  }
  const Json referencePoints = pose["points"][reference], referenceFitness = fitness[reference * count + reference];
  pose["points"] = referencePoints;
  pose.update(referenceFitness);
  pose["sources"] = Json::array();
  for (std::size_t source = 0; source < count; ++source) {
    Json row{{"source", result.levels[source]}, {"strong", source == reference}, {"targets", Json::array()}};
    for (std::size_t target = 0; target < count; ++target) {
      const Json& registered = pose["fitness_m2"][source * count + target]["registered"];
      row["targets"].push_back(registered.is_null() ? Json::object() : registered);
    }
    pose["sources"].push_back(std::move(row));
  }
}

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();  // charts do not draw points with this value
constexpr double kRounding = 1e-12;    // fitness (m²) below which values are rounding errors
constexpr std::size_t kMostPoses = 7;  // maximum number of poses in one chart; each pose is a line

using FitnessKind = FitnessSpread LevelFitness::*;  // the fitness with or without ICP

// Returns a series without points. `color`: index in the charts' palette, modulo the palette's size.
ChartSeries line(std::string name, std::size_t color) {
  return {.name = std::move(name), .color = color % kChartColors, .mark = ChartMark::LineAndDots};
}

// Adds a point at the mean, with an error bar of one standard deviation up and down, but not below the smallest value.
// A mean below kRounding is drawn as 0 without an error bar. A spread without values leaves a gap.
void addFitness(ChartSeries& series, double x, const FitnessSpread& spread, const std::string& detail) {
  const bool isPositive = spread.count > 0 && spread.mean >= kRounding;
  const double low = std::max(spread.mean - spread.deviation, spread.low);
  series.spans.push_back({isPositive ? low : kNothing, isPositive ? spread.mean + spread.deviation : kNothing});
  const double mean = isPositive ? spread.mean : 0;
  series.add({x, spread.count > 0 ? mean : kNothing},
             fmt::format("{}: {:.4g} +- {:.2g} m² of {} pairs", detail, spread.mean, spread.deviation, spread.count));
}

ChartAxis logAxis(const std::string& title) {
  return {.title = title, .scale = AxisScale::Log};
}

Chart fitnessAxes(const char* name, const std::string& title, const std::string& note) {
  return {.name = name,
          .title = title,
          .note = note,
          .x = logAxis("distance to the object (m)"),
          .y = logAxis("fitness: mean squared distance (m²)")};
}

std::vector<const RepeatedPose*> posesByDistance(const RepeatedView& view) {
  std::vector<const RepeatedPose*> poses;
  for (const RepeatedPose& pose : view.poses) poses.push_back(&pose);
  std::ranges::stable_sort(poses, {}, &RepeatedPose::distance);
  return poses;
}

std::string distanceText(const RepeatedPose& pose) {
  return fmt::format("{:.3g} m", pose.distance);
}

// Adds `series` with the fitness of pairs of scans with the noise `level`, against the distance of the view's poses.
void addLine(Chart& chart, const Repeatability& result, const RepeatedView& view, std::size_t level, FitnessKind kind,
             ChartSeries series) {
  for (const RepeatedPose* pose : posesByDistance(view)) {
    addFitness(series, pose->distance, result.at(*pose, level, level).*kind, distanceText(*pose));
  }
  chart.series.push_back(std::move(series));
}

// Returns a chart of the fitness of scans with the reference noise against the distance, with a line for each view.
Chart fitnessChart(const Repeatability& result, std::size_t method, FitnessKind kind, const char* name,
                   const char* title) {
  Chart chart = fitnessAxes(name, title,
                            fmt::format("Noise {} on both scans; {} scans of each pose, all ordered pairs. Bars: "
                                        "standard deviation.",
                                        result.levels[result.reference], result.scans));
  for (const RepeatedView& view : result.views) {
    if (view.method != method) continue;
    addLine(chart, result, view, result.reference, kind, line(view.name, chart.series.size()));
  }
  return chart;
}

// Returns a chart of the number of points with the reference noise against the distance, with a line for each view.
Chart pointsChart(const Repeatability& result, std::size_t method) {
  Chart chart{.name = "points",
              .title = "Points against distance",
              .note = fmt::format("Within {:g} m of the object's box; noise {}. Points fall as 1 / distance².",
                                  result.margin, result.levels[result.reference]),
              .x = logAxis("distance to the object (m)"),
              .y = logAxis("points of a scan")};
  for (const RepeatedView& view : result.views) {
    if (view.method != method) continue;
    ChartSeries series = line(view.name, chart.series.size());
    for (const RepeatedPose* pose : posesByDistance(view)) {
      const PointCount& count = pose->points[result.reference];
      series.add({pose->distance, count.mean},
                 fmt::format("{}: {:g} points, {} to {}", distanceText(*pose), count.mean, count.least, count.most));
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

// Returns a chart with a line for each pose: the fitness of scans with the reference noise after ICP onto scans with
// each noise level.
Chart levelsChart(const Repeatability& result, const RepeatedView& view) {
  Chart chart{.name = "noise_levels"};
  chart.title = fmt::format("{}: {} against other noise", view.name, result.levels[result.reference]);
  chart.note = fmt::format(
      "Scans with noise {0} moved by ICP onto scans with the noise below, by distance; marks without a line: onto "
      "others "
      "with {0}. Bars: standard deviation.",
      result.levels[result.reference]);
  chart.x.title = "noise of the target";
  chart.x.names = result.levels;
  chart.y = logAxis("fitness after ICP (m²)");
  const std::vector<const RepeatedPose*> poses = posesByDistance(view);
  const std::size_t step = (poses.size() + kMostPoses - 1) / kMostPoses;
  for (std::size_t p = 0; p < poses.size(); p += step) {
    ChartSeries others = line(distanceText(*poses[p]), p / step);
    ChartSeries reference = line("", p / step);  // for targets with the reference level
    reference.mark = ChartMark::Dots;
    for (std::size_t level = 0; level < result.levels.size(); ++level) {
      addFitness(level == result.reference ? reference : others, static_cast<double>(level),
                 result.at(*poses[p], result.reference, level).registered,
                 fmt::format("{}, noise {}", distanceText(*poses[p]), result.levels[level]));
    }
    chart.series.push_back(std::move(others));
    chart.series.push_back(std::move(reference));
  }
  return chart;
}

Chart withinChart(const Repeatability& result, const RepeatedView& view) {
  Chart chart = fitnessAxes("within", fmt::format("{}: both scans with the same noise", view.name),
                            "After ICP. Bars: standard deviation.");
  for (std::size_t level = 0; level < result.levels.size(); ++level) {
    addLine(chart, result, view, level, &LevelFitness::registered, line(result.levels[level], level));
  }
  return chart;
}

// Returns a chart that compares all methods for the views with the name `view`.
Chart methodsChart(const Repeatability& result, const std::string& view) {
  Chart chart = fitnessAxes("methods", fmt::format("{}: methods", view),
                            fmt::format("After ICP; noise {} on both scans.", result.levels[result.reference]));
  for (const RepeatedView& ofMethod : result.views) {
    if (ofMethod.name != view) continue;
    addLine(chart, result, ofMethod, result.reference, &LevelFitness::registered,
            line(result.methods[ofMethod.method], ofMethod.method));
  }
  return chart;
}

}  // namespace

std::string repeatabilityReport(const Repeatability& result, const std::string& date) {
  std::vector<std::string> objects, sensors;
  for (const RepeatedView& view : result.views) {
    appendNew({view.sensor}, sensors);
    for (const RepeatedPose& pose : view.poses) appendNew({pose.object}, objects);
  }
  Json page = parseJson(repeatabilityJson(result), "repeatability.json");
  page.update({{"title", "Repeatability: " + result.pipelineName},
               {"date", date},
               {"objects", objects},
               {"sensors", sensors},
               {"warnings", result.warnings},
               {"last_seed", result.seed + result.scans - 1},
               {"ordered_pairs", std::uint64_t{result.scans} * (result.scans - 1)},
               {"several", result.methods.size() > 1}});
  for (const std::string& level : result.levels) page["targets"].push_back({{"target", level}});
  for (std::size_t m = 0; m < result.methods.size(); ++m) {
    page["of_methods"].push_back({{"number", m},
                                  {"method", result.methods[m]},
                                  {"charts", chartValues(repeatabilityCharts(result, m))},
                                  {"places", Json::array()}});
  }
  for (std::size_t v = 0; v < result.views.size(); ++v) {
    const RepeatedView& view = result.views[v];
    Json& values = page["views"][v];
    values["number"] = v;
    values["charts"] = chartValues(repeatabilityViewCharts(result, view));
    for (Json& pose : values["places"]) {
      addTableRows(pose, result);
      pose.update({{"view", view.name}, {"sensor", view.sensor}});
      page["of_methods"][view.method]["places"].push_back(pose);
    }
    if (view.method == 0) page["method_charts"].push_back(chartValues(methodsChart(result, view.name)));
  }
  // With one noise level, the page has no comparison of levels by view.
  if (result.levels.size() < 2) page["views"] = Json::array();
  return fillPage(kRepeatabilityTemplate, std::move(page));
}

std::vector<Chart> repeatabilityCharts(const Repeatability& result, std::size_t method) {
  return {fitnessChart(result, method, &LevelFitness::registered, "fitness", "Fitness after ICP against distance"),
          fitnessChart(result, method, &LevelFitness::unmoved, "fitness_without_icp",
                       "Fitness without ICP against distance"),
          pointsChart(result, method)};
}

std::vector<Chart> repeatabilityViewCharts(const Repeatability& result, const RepeatedView& view) {
  return {levelsChart(result, view), withinChart(result, view)};
}

}  // namespace scanmill
