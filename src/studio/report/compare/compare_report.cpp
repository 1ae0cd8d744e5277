#include "report/compare/compare_report.h"

#include <fmt/core.h>

#include <cmath>

#include "report/page/page.h"

namespace scanmill {

namespace {

constexpr std::size_t kReal = 0, kSimulated = 1;  // indices of colours in the charts' palette
constexpr std::size_t kMostNamed = 3;             // maximum number of features that the page names for a group

// Adds to each item of a list the title, explanation and pipeline keys of its row in the table `rows`, which is the row
// with the name item[key]. compare.json has no titles and explanations, which are for users.
void addWords(Json& list, const char* key, const auto& rows) {
  for (Json& item : list) {
    for (const auto& row : rows) {
      if (item.at(key) == row.name) item.update({{"title", row.title}, {"meaning", row.meaning}, {"keys", row.keys}});
    }
  }
}

std::string_view endText(const KeyChange& advice) {
  return !advice.isEnd ? "" : advice.suggestedValue > advice.currentValue ? " (the most)" : " (the least)";
}

Chart featureChart(const SetComparison& comparison) {
  Chart chart{.name = "features",
              .title = "What separates the sets",
              .note = fmt::format("Each feature of local patches alone, compared within {} and bands of range.",
                                  comparison.byClass ? "classes" : "shapes"),
              .x = {.title = "|area under the ROC curve - 0.5|", .low = 0, .high = 0.5}};
  ChartSeries bars{.name = "real against simulated", .color = kSimulated, .mark = ChartMark::Bars};
  ChartSeries within{.name = "odd against even real scans", .color = kReal};
  for (const Separation& s : comparison.features) {
    const auto place = static_cast<double>(chart.y.names.size());
    chart.y.names.emplace_back(kPatchFeatures[s.feature].title);
    bars.add({s.strength, place}, fmt::format("{}: {:.3f}", kPatchFeatures[s.feature].title, s.strength));
    within.points.push_back({comparison.withinReal[s.feature], place});
  }
  chart.height = 120 + 26 * static_cast<int>(chart.y.names.size());
  chart.series = {bars, within};
  return chart;
}

// Returns the chart with two bars for each name. `rows`: part of the comparison's JSON. `name`, `real`, `simulated`:
// keys in each row. `factor`: multiplies the values.
Chart pairChart(Chart chart, const Json& rows, const char* name, const char* real, const char* simulated,
                double factor) {
  chart.x.low = 0;
  chart.series = {{.name = "real", .color = kReal, .mark = ChartMark::Bars},
                  {.name = "simulated", .color = kSimulated, .mark = ChartMark::Bars}};
  for (const Json& row : rows) {
    for (std::size_t i = 0; i < 2; ++i) {
      const Json& value = row.at(i == 0 ? real : simulated);
      const double figure = value.is_null() ? NAN : factor * value.get<double>();
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
  return fmt::format("{:g}{}", advice.suggestedValue, endText(advice));
}

std::string comparisonPage(const SetComparison& comparison, const std::string& date) {
  Json page = parseJson(comparisonJson(comparison, date), "compare.json");
  addWords(page["features"], "feature", kPatchFeatures);
  addWords(page["figures"], "figure", kSetFigures);
  page["definitions"] = Json::array();
  const auto define = [&](const auto& rows) {
    for (const auto& row : rows) page["definitions"].push_back({{"title", row.title}, {"meaning", row.meaning}});
  };
  define(kPatchFeatures);
  define(kSetFigures);
  for (Json& feature : page["features"]) {
    const Json& within = feature.at("strength_within_real");
    feature["strong"] = !within.is_null() && feature.at("strength") > 2 * within.get<double>();
  }
  page["set_figures"] = Json::array();
  for (const Json& figure : page["figures"]) {
    if (!figure.at("real").is_null() || !figure.at("simulated").is_null()) page["set_figures"].push_back(figure);
  }
  page.erase("figures");
  for (std::size_t i = 0; i < comparison.advice.size(); ++i) {
    const KeyChange& a = comparison.advice[i];
    page["advice"][i].update({{"real", a.real}, {"simulated", a.simulated}, {"unit", a.unit}, {"end", endText(a)}});
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
      {featureChart(comparison),
       pairChart({.name = "shares", .title = "Shares of the points", .x = share}, page["groups"], "name", "real_share",
                 "simulated_share", 100),
       pairChart({.name = "ranges", .title = "Ranges", .x = share}, page["ranges"], "band", "real_share",
                 "simulated_share", 100),
       pairChart({.name = "intensity_by_range", .title = "Intensity by range", .note = "Medians.", .x = intensity},
                 page["intensity_by_range"], "band", "real", "simulated", 1),
       pairChart(
           {.name = "intensity_by_incidence", .title = "Intensity by incidence", .note = "Medians.", .x = intensity},
           page["intensity_by_incidence"], "band", "real", "simulated", 1)});
  return fillPage(kCompareTemplate, std::move(page));
}

}  // namespace scanmill
