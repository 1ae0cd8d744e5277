#include "report/compare/compare_report.h"

#include <fmt/core.h>

#include <cmath>
#include <span>

#include "report/page/page.h"
#include "study/figure_text.h"

namespace scanmill {

namespace {

constexpr std::size_t kReal = 0, kSimulated = 1;  // indices of colours in the charts' palette
constexpr std::size_t kMostNamed = 3;             // maximum number of features that the page names for a group

// Adds to each item of a list the title, explanation and pipeline keys of the figure with the name item[key].
// compare.json has no titles and explanations, which are for users.
void addWords(Json& list, const char* key, std::span<const ComparedFigure> figures) {
  for (Json& item : list) {
    for (const ComparedFigure& f : figures) {
      if (item.at(key) == f.name) item.update({{"title", f.title}, {"meaning", f.meaning}, {"keys", f.keys}});
    }
  }
}

// Returns a chart with a row per feature: its separation of the two sets, and of two halves of the real set.
Chart featureChart(const SetComparison& comparison) {
  Chart chart{.name = "features",
              .title = "What separates the sets",
              .note = fmt::format("Each feature of local patches alone, compared within {} and bands of range.",
                                  comparison.byClass ? "classes" : "shapes"),
              .x = {.title = "|area under the ROC curve - 0.5|", .low = 0, .high = 0.5}};
  ChartSeries bars{.name = "real against simulated", .color = kSimulated, .mark = ChartMark::Bars};
  ChartSeries within{.name = "odd against even real scans", .color = kReal};
  for (const Separation& s : comparison.features) {
    const auto row = static_cast<double>(chart.y.names.size());
    chart.y.names.push_back(std::string(kPatchFeatures[s.feature].title) +
                            (kPatchFeatures[s.feature].isOfScene ? " (scene)" : ""));
    bars.add({s.strength, row}, fmt::format("{}: {:.3f}", kPatchFeatures[s.feature].title, s.strength));
    within.points.push_back({comparison.withinReal[s.feature], row});
  }
  chart.height = 120 + 26 * static_cast<int>(chart.y.names.size());
  chart.series = {bars, within};
  return chart;
}

// Returns a list of two tables: the rows that a setting changes, and those that only another scene changes. `name`:
// name of each table's list of rows.
Json byMover(const Json& rows, const char* name) {
  Json groups = Json::array();
  for (const bool isOfScene : {false, true}) {
    Json& group = groups.emplace_back();
    group["moved_by"] = isOfScene ? "Only another scene changes these" : "A setting can change these";
    for (const Json& row : rows) {
      if (row.at("only_scene") == isOfScene) group[name].push_back(row);
    }
    if (!group.contains(name)) groups.erase(groups.size() - 1);
  }
  return groups;
}

// Returns the rows of the table of surfaces, one per group and band.
Json surfaceRows(const SetComparison& comparison) {
  Json rows = Json::array();
  for (const GroupComparison& group : comparison.groups) {
    for (const SurfaceComparison& surface : group.surfaces) {
      Json& row = rows.emplace_back();
      row = {{"group", group.name}, {"band", surface.band}};
      for (std::size_t f = 0; f < kSurfaceFigureCount; ++f) {
        const ComparedFigure& figure = kSurfaceFigures[f];
        const bool isUnlike = surface.isCounted(f) && !surface.isAlike(f);
        row["cells"].push_back(
            {{"title", fmt::format("{} ({})", figure.title, figure.unit)},
             {"meaning", figure.meaning},
             {"keys", figure.keys},
             {"pair", threeDigits(surface.real[f]) + " / " + threeDigits(surface.simulated[f]) +
                          (isUnlike ? fmt::format(" ({:.3g})", surface.simulated[f] / surface.real[f]) : "")}});
      }
    }
  }
  return rows;
}

// Returns a chart with a row per group, and in it a dot per band of ranges and figure: simulated over real.
Chart surfaceChart(const SetComparison& comparison) {
  Chart chart{
      .name = "surfaces",
      .title = "Surfaces in the small",
      .note =
          "Each dot is a band of ranges: to the right of the lines the simulated set is rougher or has more gaps, "
          "to the left less, by more than a factor of 1.5. At 0: it has none.",
      .x = {.title = "simulated / real", .scale = AxisScale::Log}};
  for (std::size_t f = 0; f < kSurfaceFigureCount; ++f) {
    chart.series.push_back({.name = std::string(kSurfaceFigures[f].title), .color = f});
  }
  for (const GroupComparison& group : comparison.groups) {
    if (group.surfaces.empty()) continue;
    const auto row = static_cast<double>(chart.y.names.size());
    chart.y.names.push_back(group.name);
    for (const SurfaceComparison& surface : group.surfaces) {
      for (std::size_t f = 0; f < kSurfaceFigureCount; ++f) {
        if (!surface.isCounted(f)) continue;
        chart.series[f].add({surface.simulated[f] / surface.real[f], row},
                            fmt::format("{}, {}: {:.3g} and {:.3g} {}", group.name, surface.band, surface.real[f],
                                        surface.simulated[f], kSurfaceFigures[f].unit));
      }
    }
  }
  for (const double limit : {1 / kAlike, kAlike}) {
    ChartSeries line{.mark = ChartMark::Line};
    line.points = {{limit, 0}, {limit, static_cast<double>(chart.y.names.size()) - 1}};
    chart.series.push_back(std::move(line));
  }
  chart.height = 150 + 26 * static_cast<int>(chart.y.names.size());
  return chart;
}

// Returns `chart` with two bars for each row. `name`: JSON key of a row's name. `ofShares`: true for shares, shown in
// per cent.
Chart pairChart(Chart chart, const Json& rows, const char* name, bool ofShares = false) {
  chart.x.low = 0;
  chart.series = {{.name = "real", .color = kReal, .mark = ChartMark::Bars},
                  {.name = "simulated", .color = kSimulated, .mark = ChartMark::Bars}};
  for (const Json& row : rows) {
    for (std::size_t i = 0; i < 2; ++i) {
      const Json& value = row.at(chart.series[i].name + (ofShares ? "_share" : ""));
      const double figure = value.is_null() ? NAN : (ofShares ? 100 : 1) * value.get<double>();
      chart.series[i].add({figure, static_cast<double>(chart.y.names.size())},
                          value.is_null() ? "" : fmt::format("{}: {:.3g}", row.at(name).get<std::string>(), figure));
    }
    chart.y.names.push_back(row.at(name));
  }
  chart.height = 130 + 34 * static_cast<int>(chart.y.names.size());
  return chart;
}

}  // namespace

std::string figureText(double value, double factor, std::string_view unit) {
  if (!std::isfinite(value)) return "-";
  return fmt::format("{:.3g}{}{}", value * factor, unit.empty() ? "" : " ", unit);
}

std::string nextText(const KeyChange& advice) {
  const bool isMost = advice.suggested > advice.current;
  return advice.suggestedText() + (!advice.isEnd ? "" : isMost ? " (the most)" : " (the least)");
}

std::string comparisonPage(const SetComparison& comparison, const std::string& date) {
  Json page = parseJson(comparisonJson(comparison, date), "compare.json");
  addWords(page["road_pose"], "figure", kRoadFigures);
  addWords(page["features"], "feature", kPatchFeatures);
  addWords(page["figures"], "figure", kSetFigures);
  page["definitions"] = Json::array();
  for (const std::span<const ComparedFigure> figures :
       {std::span<const ComparedFigure>(kRoadFigures), {kPatchFeatures}, {kSurfaceFigures}, {kSetFigures}}) {
    for (const ComparedFigure& f : figures) page["definitions"].push_back({{"title", f.title}, {"meaning", f.meaning}});
  }
  for (Json& feature : page["features"]) {
    const Json& within = feature.at("strength_within_real");
    feature["strong"] = !within.is_null() && feature.at("strength") > 2 * within.get<double>();
  }
  for (const auto& [rows, shown] : {std::pair("figures", "set_figures"), {"road_pose", "shown_pose"}}) {
    page[shown] = Json::array();
    for (const Json& row : page[rows]) {
      if (!row.at("real").is_null() || !row.at("simulated").is_null()) page[shown].push_back(row);
    }
    page.erase(rows);
  }
  page["feature_groups"] = byMover(page["features"], "features");
  page["set_figure_groups"] = byMover(page["set_figures"], "set_figures");
  page["surfaces"] = surfaceRows(comparison);
  if (!page["surfaces"].empty()) page["cells"] = page["surfaces"][0]["cells"];  // for the headings of the columns
  for (std::size_t i = 0; i < comparison.advice.size(); ++i) {
    const KeyChange& change = comparison.advice[i];
    page["advice"][i].update({{"try", nextText(change)},
                              {"real", change.figure.real},
                              {"simulated", change.figure.simulated},
                              {"unit", change.figure.unit}});
  }
  for (Json& group : page["groups"]) {
    addWords(group["features"], "feature", kPatchFeatures);
    group["real_percent"] = 100 * group.at("real_share").get<double>();
    group["simulated_percent"] = 100 * group.at("simulated_share").get<double>();
    for (const Json& feature : group["features"]) {
      if (group["first"].size() == kMostNamed) break;
      group["first"].push_back(feature);
      group["first"].back()["more"] = group["first"].size() > 1;
    }
  }
  page["by_class"] = comparison.byClass;
  page["title"] = fmt::format("{} and {}", comparison.real.name, comparison.simulated.name);
  const ChartAxis share{.title = "share of the points (%)"}, intensity{.title = "intensity / median"};
  page["charts"] = chartValues(
      {featureChart(comparison), surfaceChart(comparison),
       pairChart({.name = "shares", .title = "Shares of the points", .x = share}, page["groups"], "name", true),
       pairChart({.name = "ranges", .title = "Ranges", .x = share}, page["ranges"], "band", true),
       pairChart({.name = "intensity_by_range", .title = "Intensity by range", .note = "Medians.", .x = intensity},
                 page["intensity_by_range"], "band"),
       pairChart(
           {.name = "intensity_by_incidence", .title = "Intensity by incidence", .note = "Medians.", .x = intensity},
           page["intensity_by_incidence"], "band")});
  return fillPage(kCompareTemplate, std::move(page));
}

}  // namespace scanmill
