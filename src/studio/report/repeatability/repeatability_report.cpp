#include "report/repeatability/repeatability_report.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "charts/svg_text.h"
#include "report/page/report_html.h"

namespace scanmill {

namespace {

HtmlCell nameCell(const std::string& name, const std::string& hint) {
  HtmlCell cell{name};
  cell.hint = hint;
  return cell;
}

HtmlCell meanCell(const FitnessSpread& spread) {
  if (spread.count == 0) return {"-"};
  return {squareCentimetres(spread.mean, spread.mean), spread.mean,
          fmt::format("{} to {}, {} pairs", squareCentimetres(spread.low, spread.mean),
                      squareCentimetres(spread.high, spread.mean), spread.count)};
}

HtmlCell deviationCell(const FitnessSpread& spread) {
  if (!hasDeviation(spread)) return {"-"};
  return {squareCentimetres(spread.deviation, spread.mean), spread.deviation};
}

std::string placesTable(const Repeatability& result, std::size_t method) {
  HtmlTable table;
  table.group("", 5);
  table.group("after ICP (cm²)", 3);
  table.group("without ICP (cm²)", 2);
  table.column("view");
  table.column("object");
  table.column("frame");
  table.column("distance (m)");
  table.column("points", "mean over the scans");
  table.column("mean");
  table.column("deviation");
  table.column("pairs", "that ICP moved: it takes three points on each side");
  table.column("mean");
  table.column("deviation");
  for (const RepeatedView& view : result.views) {
    if (view.method != method) continue;
    for (const RepeatedPlace& place : view.places) {
      const LevelFitness& cell = result.at(place, result.reference, result.reference);
      const PointCount& count = place.points[result.reference];
      table.row({nameCell(view.name, view.sensor),
                 {place.object},
                 {std::to_string(place.frame), static_cast<double>(place.frame)},
                 {fmt::format("{:.4g}", place.distance), place.distance},
                 {fmt::format("{:.4g}", count.mean), count.mean, fmt::format("{} to {}", count.least, count.most)},
                 meanCell(cell.registered),
                 deviationCell(cell.registered),
                 {fmt::format("{} of {}", cell.registered.count, cell.pairs)},
                 meanCell(cell.unmoved),
                 deviationCell(cell.unmoved)});
    }
  }
  return table.html();
}

std::string levelsTable(const Repeatability& result, const RepeatedPlace& place) {
  HtmlTable table;
  table.column("source \\ target");
  for (const std::string& level : result.levels) table.column(level);
  for (std::size_t source = 0; source < result.levels.size(); ++source) {
    std::vector<HtmlCell> cells{{result.levels[source]}};
    for (std::size_t target = 0; target < result.levels.size(); ++target) {
      cells.push_back(meanCell(result.at(place, source, target).registered));
    }
    table.row(std::move(cells), source == result.reference);
  }
  return table.html();
}

std::string folded(const std::string& summary, const std::string& body) {
  return fmt::format("<details><summary>{}</summary>{}</details>\n", escapeXml(summary), body);
}

std::string viewBody(const Repeatability& result, const RepeatedView& view) {
  std::string tables;
  for (const RepeatedPlace& place : view.places) {
    tables += htmlParagraph(fmt::format("{} at {:.4g} m, frame {}: fitness after ICP (cm²)", place.object,
                                        place.distance, place.frame)) +
              levelsTable(result, place);
  }
  return htmlFigures({repeatabilityLevelsSvg(result, view), repeatabilityWithinSvg(result, view)}) +
         folded("All pairs of noise levels", tables);
}

std::string limitText(double metres) {
  return std::isfinite(metres) ? fmt::format("{:g} m", metres) : "no limit";
}

std::string facts(const Repeatability& result, const std::string& date) {
  std::string levels;
  for (const std::string& level : result.levels) levels += (levels.empty() ? "" : ", ") + level;
  std::string out = "<dl class=\"facts\">";
  const auto fact = [&](const std::string& name, const std::string& text) {
    out += fmt::format("<dt>{}</dt><dd>{}</dd>", escapeXml(name), escapeXml(text));
  };
  fact("object", fmt::format("{}", fmt::join(result.objects(), ", ")));
  fact("sensor", fmt::format("{}", fmt::join(result.sensors(), ", ")));
  fact("scans",
       fmt::format("{} of each pose, with seeds {} to {}", result.scans, result.seed, result.seed + result.scans - 1));
  fact("noise", levels);
  fact("cropped to", fmt::format("the object's box and {:g} m around it", result.margin));
  fact("ICP", fmt::format("PCL's, at most {} iterations; matched points {} apart, {} in the fitness",
                          result.icp.iterations, limitText(result.icp.reach), limitText(result.icp.fitnessWithin)));
  fact("pairs", fmt::format("all {} ordered pairs of scans with different seeds, within a noise and between two",
                            result.scans * (result.scans - 1)));
  fact("program", fmt::format("scanmill {}, {}", result.programVersion, date));
  return out + "</dl>\n";
}

}  // namespace

std::string squareCentimetres(double fitness, double like) {
  constexpr double kSquareCentimetres = 1e4;  // a square metre
  constexpr int kMostDecimals = 4;            // less is rounding
  const double size = std::log10(std::max(like * kSquareCentimetres, 1e-9));
  return fmt::format("{:.{}f}", fitness * kSquareCentimetres,
                     std::clamp(2 - static_cast<int>(std::floor(size)), 0, kMostDecimals));
}

std::string repeatabilityReport(const Repeatability& result, const std::string& date) {
  std::string warnings;
  for (const std::string& w : result.warnings) warnings += htmlParagraph("Warning: " + w, "card");
  std::vector<HtmlSection> sections;
  for (std::size_t m = 0; m < result.methods.size(); ++m) {
    const std::string suffix = result.methods.size() > 1 ? ", " + result.methods[m] : "";
    sections.push_back({fmt::format("distance-{}", m), "Fitness and points against distance" + suffix,
                        "Fitness is the mean of squared distances from each point of one scan to the nearest of the "
                        "other: it rises with "
                        "the noise, and as points thin out.",
                        htmlFigures({repeatabilityRegisteredSvg(result, m), repeatabilityUnmovedSvg(result, m),
                                     repeatabilityPointsSvg(result, m), repeatabilityShareSvg(result, m)}) +
                            folded("The figures", placesTable(result, m))});
  }
  // With one noise alone there is nothing to compare it with.
  for (std::size_t v = 0; result.levels.size() > 1 && v < result.views.size(); ++v) {
    const RepeatedView& view = result.views[v];
    const std::string suffix = result.methods.size() > 1 ? ", " + result.methods[view.method] : "";
    sections.push_back({fmt::format("view-{}", v), view.name + suffix, "", viewBody(result, view)});
  }
  if (result.methods.size() > 1) {
    std::vector<std::string> charts;
    for (const RepeatedView& view : result.views) {
      if (view.method == 0) charts.push_back(repeatabilityMethodsSvg(result, view.name));
    }
    sections.push_back({"methods", "Methods", "", htmlFigures(charts)});
  }
  sections.push_back({"again", "The pipeline", "", htmlCode(result.pipelineText)});
  return htmlPage(
      "Repeatability: " + result.pipelineName,
      htmlParagraph("How well repeated scans of one object agree: scanned several times from each pose with "
                    "other noise, cropped to the object, moved onto one another by ICP.",
                    "lead") +
          facts(result, date) + warnings,
      sections);
}

}  // namespace scanmill
