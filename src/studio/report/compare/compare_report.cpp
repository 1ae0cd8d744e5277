#include "report/compare/compare_report.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/grouped.h"
#include "charts/chart.h"
#include "config/version.h"
#include "report/page/report_html.h"

namespace scanmill {

namespace {

constexpr std::size_t kReal = 0, kSimulated = 1;  // places in the charts' palette
constexpr double kPercent = 100;

HtmlCell cell(double value, double factor, std::string_view unit) {
  return {figureText(value, factor, unit), value};
}

HtmlCell shareCell(double share) {
  return {fmt::format("{:.1f} %", kPercent * share), share};
}

// `within`: of all groups together.
std::string featureTable(const SetComparison& comparison, const std::vector<Separation>& features, bool ofAll) {
  HtmlTable table;
  table.column("feature of a patch", "", true);
  table.column("tells apart", "mean over bands of range of |area under the ROC curve - 0.5|: 0 not at all, 0.5 surely");
  if (ofAll) table.column("within real", "the same between odd and even scans of the first set: what places differ in");
  table.column("area", "above 0.5 where the second set has the greater values");
  table.column("real", "median; mean of what is mostly zero");
  table.column("simulated", "median; mean of what is mostly zero");
  table.column("what moves it", "keys of a pipeline", true);
  for (const Separation& s : features) {
    const PatchFeature& f = kPatchFeatures[s.feature];
    const double within = comparison.withinReal[s.feature];
    std::vector<HtmlCell> cells{{std::string(f.title), NAN, std::string(f.meaning)},
                                {fmt::format("{:.3f}", s.strength), s.strength,
                                 fmt::format("{} and {} patches", grouped(s.real), grouped(s.simulated))}};
    if (ofAll) cells.push_back({std::isnan(within) ? "-" : fmt::format("{:.3f}", within), within});
    cells.insert(cells.end(), {{fmt::format("{:.3f}", s.area), s.area},
                               cell(s.realValue, f.factor, f.unit),
                               cell(s.simulatedValue, f.factor, f.unit),
                               {std::string(f.keys)}});
    table.row(std::move(cells), ofAll && (std::isnan(within) || s.strength > 2 * within));
  }
  return table.html();
}

std::string featureChart(const SetComparison& comparison) {
  Chart chart;
  chart.title = "What tells the sets apart";
  chart.note = fmt::format("Single features of local patches, compared within {} and bands of range.",
                           comparison.byClass ? "classes" : "shapes");
  chart.x.title = "|area under the ROC curve - 0.5|";
  chart.x.low = 0;
  chart.x.high = 0.5;
  ChartSeries bars{.name = "real against simulated", .color = kSimulated, .mark = ChartMark::Bars};
  ChartSeries within{.name = "odd against even real scans", .color = kReal, .mark = ChartMark::Dots};
  for (const Separation& s : comparison.features) {
    const auto place = static_cast<double>(chart.y.names.size());
    chart.y.names.emplace_back(kPatchFeatures[s.feature].title);
    bars.points.push_back({s.strength, place});
    bars.details.push_back(fmt::format("{}: {:.3f}", kPatchFeatures[s.feature].title, s.strength));
    if (!std::isnan(comparison.withinReal[s.feature])) {
      within.points.push_back({comparison.withinReal[s.feature], place});
    }
  }
  chart.height = 120 + 26 * static_cast<int>(chart.y.names.size());
  chart.series = {bars};
  if (!within.points.empty()) chart.series.push_back(within);
  return drawSvg(chart);
}

// Two bars for each name; values that are not finite are left out.
struct Pair {
  std::string name;
  double real = 0, simulated = 0;
};

std::string pairChart(const std::string& title, const std::string& note, const std::string& axis,
                      const std::vector<Pair>& pairs) {
  if (pairs.empty()) return {};
  Chart chart;
  chart.title = title;
  chart.note = note;
  chart.x.title = axis;
  chart.x.low = 0;
  ChartSeries real{.name = "real", .color = kReal, .mark = ChartMark::Bars};
  ChartSeries simulated{.name = "simulated", .color = kSimulated, .mark = ChartMark::Bars};
  for (const Pair& pair : pairs) {
    // A row of its own for each, the name at the upper one, and an empty row before the next pair.
    if (!chart.y.names.empty()) chart.y.names.emplace_back("");
    const auto place = static_cast<double>(chart.y.names.size());
    chart.y.names.push_back(pair.name);
    chart.y.names.emplace_back("");
    real.points.push_back({pair.real, place});
    simulated.points.push_back({pair.simulated, place + 1});
    real.details.push_back(fmt::format("{}: {:.3g}", pair.name, pair.real));
    simulated.details.push_back(fmt::format("{}: {:.3g}", pair.name, pair.simulated));
  }
  chart.height = 130 + 17 * static_cast<int>(chart.y.names.size());
  chart.series = {real, simulated};
  return drawSvg(chart);
}

std::string figureTable(const SetComparison& comparison) {
  HtmlTable table;
  table.column("figure", "", true);
  table.column("real");
  table.column("simulated");
  table.column("what moves it", "keys of a pipeline", true);
  for (std::size_t i = 0; i < kSetFigureCount; ++i) {
    const SetFigure& f = kSetFigures[i];
    if (std::isnan(comparison.real.figures[i]) && std::isnan(comparison.simulated.figures[i])) continue;
    table.row({{std::string(f.title), NAN, std::string(f.meaning)},
               cell(comparison.real.figures[i], f.factor, f.unit),
               cell(comparison.simulated.figures[i], f.factor, f.unit),
               {std::string(f.keys)}});
  }
  return table.html();
}

std::string adviceTable(const SetComparison& comparison) {
  if (comparison.advice.empty()) return {};
  HtmlTable table;
  table.column("effect", "", true);
  table.column("key", "", true);
  table.column("now");
  table.column("try");
  table.column("what tells of it", "", true);
  table.column("real");
  table.column("simulated");
  for (const KeyChange& a : comparison.advice) {
    table.row({{std::string(a.effect)},
               {std::string(a.key)},
               {fmt::format("{:g}", a.now), a.now},
               {nextText(a), a.next},
               {std::string(a.figure)},
               cell(a.real, 1, a.unit),
               cell(a.simulated, 1, a.unit)});
  }
  return table.html() +
         htmlParagraph(
             "All of it, as an option beside those of the command that made the set; it is for all sensors:") +
         htmlCode(fmt::format("--set '{}'", comparison.assignment));
}

std::string groupTable(const SetComparison& comparison) {
  constexpr std::size_t kShown = 3;
  HtmlTable table;
  table.column(comparison.byClass ? "class" : "shape", "", true);
  table.column("real", "share of the patches");
  table.column("simulated", "share of the patches");
  table.column("what tells its patches apart most", "feature, |area - 0.5|, values real and simulated", true);
  for (const GroupComparison& group : comparison.groups) {
    std::vector<std::string> first;
    for (const Separation& s : group.features) {
      if (first.size() == kShown) break;
      const PatchFeature& f = kPatchFeatures[s.feature];
      first.push_back(fmt::format("{} {:.2f} ({} and {})", f.title, s.strength,
                                  figureText(s.realValue, f.factor, f.unit),
                                  figureText(s.simulatedValue, f.factor, f.unit)));
    }
    table.row({{group.name},
               shareCell(group.realShare),
               shareCell(group.simulatedShare),
               {first.empty() ? "too few patches at like ranges" : fmt::format("{}", fmt::join(first, "; "))}});
  }
  return table.html();
}

std::string details(const SetComparison& comparison) {
  std::string html;
  for (const GroupComparison& group : comparison.groups) {
    if (!group.features.empty()) html += htmlDetails(group.name, featureTable(comparison, group.features, false));
  }
  return html;
}

std::string definitions() {
  HtmlTable table;
  table.column("feature or figure", "", true);
  table.column("what it is", "", true);
  for (const PatchFeature& f : kPatchFeatures) table.row({{std::string(f.title)}, {std::string(f.meaning)}});
  for (const SetFigure& f : kSetFigures) table.row({{std::string(f.title)}, {std::string(f.meaning)}});
  return htmlDetails("What each is", table.html()) +
         htmlParagraph(
             "Shapes: the plane through a patch tells level (up to 25 deg), upright (from 65 deg) and slanted "
             "ones; rough ones are thicker than 0.35 of their lesser width, sparse ones have fewer than 12 "
             "points nearby in range.");
}

std::string setText(const ScanSet& set) {
  return fmt::format("{} ({} of {} scans, {} points{}{}{})", set.name, set.scans, set.stored, grouped(set.points),
                     set.labelled ? ", labelled" : "", set.knowsRings ? "" : ", rings unknown",
                     set.knowsMisses ? "" : ", missing beams unknown");
}

std::vector<Pair> pairsOf(const std::vector<IntensityRow>& rows) {
  std::vector<Pair> pairs;
  for (const IntensityRow& row : rows) pairs.push_back({row.name, row.real, row.simulated});
  return pairs;
}

}  // namespace

std::string figureText(double value, double factor, std::string_view unit) {
  if (!std::isfinite(value)) return "-";
  return fmt::format("{:.3g}{}{}", value * factor, unit.empty() ? "" : " ", unit);
}

std::string nextText(const KeyChange& advice) {
  return fmt::format("{:g}{}", advice.next,
                     advice.isEnd ? advice.next > advice.now ? " (the most)" : " (the least)" : "");
}

std::string comparisonPage(const SetComparison& comparison, const std::string& date) {
  std::vector<Pair> ranges, shares;
  for (const BandComparison& band : comparison.ranges) {
    ranges.push_back({band.name, kPercent * band.realShare, kPercent * band.simulatedShare});
  }
  for (const GroupComparison& group : comparison.groups) {
    shares.push_back({group.name, kPercent * group.realShare, kPercent * group.simulatedShare});
  }
  const std::string grouping =
      comparison.byClass ? "of one class" : "of one shape, as one of the sets has no labels whose classes are known,";
  std::string unknown;
  if (!comparison.unknown.empty()) {
    unknown = fmt::format(" Classes of the second set that the first one's ontology does not have are left out: {}.",
                          fmt::join(comparison.unknown, ", "));
  }
  const std::vector<HtmlSection> sections{
      {"features", "What a network would notice first",
       fmt::format("A patch is 5 rings by 9 columns of neighbouring beams. Patches {} and one band of range are told "
                   "apart by one figure at a time. A figure of 0 says that it does not help; 0.5 that one patch is "
                   "enough. Highlighted rows differ by more than twice what the real scans differ in among "
                   "themselves, where there are several; scans that follow one another closely make that too little. "
                   "Areas of bands may lie on both sides of 0.5, and then add up to less than the figure.{}",
                   grouping, unknown),
       htmlFigures({featureChart(comparison)}) + featureTable(comparison, comparison.features, true), true},
      {"advice", "What to try",
       comparison.advice.empty()
           ? comparison.unadvised
           : "Values of the second set's pipeline that would make these figures alike, if they alone moved them. "
             "Generate, compare again, and judge by the rows above.",
       adviceTable(comparison)},
      {"figures", "The sets as a whole", "Figures that depend on the place, too: compare like places.",
       figureTable(comparison), true},
      {"groups", comparison.byClass ? "By class" : "By shape", "",
       htmlFigures({pairChart("Shares of the points", "", "share (%)", shares)}) + groupTable(comparison) +
           details(comparison),
       true},
      {"ranges", "By range and incidence",
       "Intensities are in units of each set's median: scales differ from sensor to sensor.",
       htmlFigures(
           {pairChart("Ranges", "", "share of the points (%)", ranges),
            pairChart("Intensity by range", "Medians.", "intensity / median", pairsOf(comparison.intensityByRange)),
            pairChart("Intensity by incidence", "Medians.", "intensity / median",
                      pairsOf(comparison.intensityByIncidence))})},
      {"definitions", "Definitions", "", definitions(), true}};
  std::string head = htmlParagraph(fmt::format("Real: {}. Simulated: {}. {}, by Scanmill {}.", setText(comparison.real),
                                               setText(comparison.simulated), date, kVersion));
  for (const std::string& warning : comparison.warnings) head += htmlParagraph("Note: " + warning);
  return htmlPage(fmt::format("{} and {}", comparison.real.name, comparison.simulated.name), head, sections);
}

}  // namespace scanmill
