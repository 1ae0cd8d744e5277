#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "base/short_text.h"
#include "charts/chart.h"
#include "evaluate/spread.h"
#include "report/dataset/dataset_report.h"
#include "report/page/page.h"
#include "study/figure_text.h"

namespace scanmill {

namespace {

constexpr int kBarHeight = 21, kAxesHeight = 120;  // height in pixels: of one bar; of a chart without its bars
constexpr std::size_t kMostClasses = 12;           // maximum number of classes in a stacked bar beside "other classes"
constexpr const char* kOtherFill = "#8b949e";

// Returns the classes for which count(class) is not zero, sorted by this count with the largest first.
std::vector<const ClassSummary*> classesWith(const DatasetSummary& summary,
                                             const std::function<std::uint64_t(const ClassSummary&)>& count) {
  std::vector<const ClassSummary*> classes;
  for (const ClassSummary& c : summary.classes) {
    if (count(c) > 0) classes.push_back(&c);
  }
  std::ranges::stable_sort(classes, [&](const auto* a, const auto* b) { return count(*a) > count(*b); });
  return classes;
}

std::string ofScans(const DatasetSummary& summary) {
  return summary.scansRead == summary.scans ? fmt::format("of all {}", pluralOf(summary.scans, "scan"))
                                            : fmt::format("of {} of {} scans", summary.scansRead, summary.scans);
}

// A ring of distances around the sensor, which consists of consecutive steps of DatasetSummary::steps.
struct DistanceRing {
  std::string name;                 // the ring's distances, such as "20 to 30 m"
  std::size_t first = 0, last = 0;  // indices of steps; `last` is excluded
};

// Returns at most eleven rings for a bar chart, which together reach to the last step with points. Rings are narrower
// near the sensor, where most points are. The last step of DatasetSummary::steps, for all larger distances, is a ring.
std::vector<DistanceRing> distanceRings(const DatasetSummary& summary) {
  const std::size_t count = summary.steps.count;
  std::size_t last = 0;
  for (const SensorSummary& s : summary.sensors) {
    for (std::size_t i = 0; i < s.ranges.size(); ++i) {
      if (s.ranges[i] > 0) last = std::max(last, i + 1);
    }
  }
  std::vector<std::size_t> ends;  // end of each ring (index of a step)
  for (const std::size_t end : {5, 10, 20, 30, 40, 50, 60, 80, 100}) {
    if (end < count - 1) ends.push_back(end);
  }
  ends.insert(ends.end(), {count - 1, count});
  std::vector<DistanceRing> rings;
  for (std::size_t first = 0, i = 0; first < last; first = ends[i++]) {
    const double low = static_cast<double>(first) * summary.steps.step;
    const double high = static_cast<double>(ends[i]) * summary.steps.step;
    rings.push_back({ends[i] == count ? fmt::format("from {:g} m", low) : fmt::format("{:g} to {:g} m", low, high),
                     first, ends[i]});
  }
  return rings;
}

// Returns the number of points in a ring. `ranges`: number of points in each of DatasetSummary::steps.
std::uint64_t pointsIn(const std::vector<std::uint64_t>& ranges, const DistanceRing& ring) {
  return std::accumulate(ranges.begin() + static_cast<std::ptrdiff_t>(ring.first),
                         ranges.begin() + static_cast<std::ptrdiff_t>(ring.last), std::uint64_t{0});
}

// Returns a chart with a bar for each ring of distance: the number of points, stacked by class.
Chart ringsChart(const DatasetSummary& summary) {
  const std::vector<DistanceRing> rings = distanceRings(summary);
  Chart chart{.name = "ring_points",
              .title = "Points per ring of distance",
              .note = fmt::format("from the sensor; a scan's mean, {}", ofScans(summary)),
              .y = {.title = "points a scan"},
              .stacked = true,
              .width = kHalfWidth,
              .height = 420};
  for (const DistanceRing& ring : rings) chart.x.names.push_back(ring.name);
  // Adds a series to the chart. `ranges`: see pointsIn(). `fill`: colour; empty: the default colour of the series.
  const auto addBars = [&](const std::string& name, const std::string& fill, const std::vector<std::uint64_t>& ranges) {
    ChartSeries bars{.name = name, .mark = ChartMark::Bars};
    for (std::size_t i = 0; i < rings.size(); ++i) {
      const double value = shareOf(pointsIn(ranges, rings[i]), summary.scansRead);
      bars.add({static_cast<double>(i), value},
               fmt::format("{}, {}: {} points a scan", name, rings[i].name, shortNumber(value)));
      if (!fill.empty()) bars.fills.push_back(fill);
    }
    chart.series.push_back(std::move(bars));
  };
  if (!summary.labelled) {
    std::vector<std::uint64_t> all(summary.steps.count, 0);
    for (const SensorSummary& s : summary.sensors) addTo(all, s.ranges);
    addBars("points", "", all);
    return chart;
  }
  const auto classes = classesWith(summary, [](const ClassSummary& c) {
    return std::accumulate(c.ranges.begin(), c.ranges.end(), std::uint64_t{0});
  });
  // If only one class would be among the "other classes", it gets a series of its own instead.
  const std::size_t shown = classes.size() > kMostClasses + 1 ? kMostClasses : classes.size();
  std::vector<std::uint64_t> others(summary.steps.count, 0);
  for (std::size_t i = 0; i < classes.size(); ++i) {
    if (i < shown) addBars(classes[i]->name, htmlColor(classes[i]->color), classes[i]->ranges);
    if (i >= shown) addTo(others, classes[i]->ranges);
  }
  if (shown < classes.size()) addBars("other classes", kOtherFill, others);
  return chart;
}

// Returns a chart with a bar for each class with points, the largest first.
Chart classChart(const DatasetSummary& summary) {
  Chart chart{.name = "class_points",
              .title = "Points per class",
              .note = "of all scans",
              .x = {.title = "points", .scale = AxisScale::Log},
              .width = kWholeWidth};
  const auto classes = classesWith(summary, [](const ClassSummary& c) { return c.points; });
  ChartSeries bars{.mark = ChartMark::Bars};
  for (const ClassSummary* c : classes) {
    bars.add({static_cast<double>(c->points), static_cast<double>(bars.points.size())},
             fmt::format("{}: {}", c->name, c->points));
    bars.labels.push_back(shareText(shareOf(c->points, summary.points)));
    bars.fills.push_back(htmlColor(c->color));
    chart.y.names.push_back(c->name);
  }
  // Extends the axis to leave space for the labels of the longest bars.
  if (!classes.empty()) chart.x.high = 4 * static_cast<double>(classes.front()->points);
  chart.height = kAxesHeight + kBarHeight * static_cast<int>(classes.size());
  chart.series.push_back(std::move(bars));
  return chart;
}

// Returns `chart` with a line for each sensor: points per scan in bins of width `step`. counts(sensor) returns the
// number of points in each bin.
Chart stepsChart(const DatasetSummary& summary, Chart chart, double step,
                 const std::function<std::vector<std::uint64_t>(const SensorSummary&)>& counts) {
  chart.note = fmt::format("points per {:g} {}; a scan's mean, {}", step, chart.note, ofScans(summary));
  chart.x.low = 0;
  chart.y = {.title = "points a scan", .scale = AxisScale::Log};
  chart.width = kHalfWidth;
  chart.height = 360;
  for (std::size_t s = 0; s < summary.sensors.size(); ++s) {
    ChartSeries line{.name = summary.sensors[s].name, .color = s, .mark = ChartMark::Line};
    const std::vector<std::uint64_t> points = counts(summary.sensors[s]);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double middle = (static_cast<double>(i) + 0.5) * step;
      line.points.push_back({middle, points[i] == 0 ? NAN : shareOf(points[i], summary.sensors[s].scansRead)});
    }
    chart.series.push_back(std::move(line));
  }
  return chart;
}

// Returns a chart with a line for each sensor: points per scan by intensity.
Chart intensitiesChart(const DatasetSummary& summary) {
  constexpr std::size_t kBins = 128;
  float largest = 0;
  for (const SensorSummary& s : summary.sensors) {
    if (!s.intensities.empty()) largest = std::max(largest, intensityOfKey(s.intensities.rbegin()->first));
  }
  // The axis ends at a power of two, so that each intensity key lies completely in one bin.
  const double high = largest > 0 ? std::exp2(std::floor(std::log2(double{largest})) + 1) : 1;
  return stepsChart(
      summary, {.name = "intensities", .title = "Intensities", .note = "of intensity", .x = {.title = "intensity"}},
      high / kBins, [&](const SensorSummary& sensor) {
        std::vector<std::uint64_t> bins(kBins, 0);
        for (const auto& [key, points] : sensor.intensities) {
          const double bin = std::clamp(double{intensityOfKey(key)} / high, 0.0, 1.0) * kBins;
          bins[std::min(static_cast<std::size_t>(bin), kBins - 1)] += points;
        }
        return bins;
      });
}

// Returns a chart with a line for each sensor: points per scan over the samples. If there are more than kMostMarks
// samples, each mark is the mean of several samples.
Chart scanPointsChart(const Manifest& manifest) {
  constexpr std::size_t kMostMarks = 400;  // maximum number of marks of a line
  constexpr std::size_t kMostDots = 80;    // a line with more marks has no dots
  const std::size_t samplesPerMark = (manifest.samples.size() + kMostMarks - 1) / kMostMarks;
  Chart chart{.name = "scan_points",
              .title = "Points a scan",
              .note = samplesPerMark > 1
                          ? fmt::format("in the order of the samples; the mean of {} each", samplesPerMark)
                          : "in the order of the samples",
              .x = {.title = "sample"},
              .y = {.title = "points", .low = 0},
              .width = kWholeWidth,
              .height = 300};
  for (std::size_t s = 0; s < manifest.sensors.size(); ++s) {
    ChartSeries line{.name = manifest.sensors[s].name,
                     .color = s,
                     .mark = manifest.samples.size() > kMostDots ? ChartMark::Line : ChartMark::LineAndDots};
    for (std::size_t first = 0; first < manifest.samples.size(); first += samplesPerMark) {
      const std::size_t end = std::min(first + samplesPerMark, manifest.samples.size());
      std::uint64_t points = 0, scans = 0;
      for (std::size_t i = first; i < end; ++i) {
        for (const ScanRecord& scan : manifest.samples[i].scans) {
          if (scan.sensor != manifest.sensors[s].name) continue;
          points += scan.points;
          ++scans;
        }
      }
      line.add({static_cast<double>(first), shareOf(points, scans, NAN)},
               fmt::format("{}: {}", manifest.samples[first].key, points));
    }
    chart.series.push_back(std::move(line));
  }
  return chart;
}

}  // namespace

std::string htmlColor(const Rgb& color) {
  return fmt::format("#{:02x}{:02x}{:02x}", color[0], color[1], color[2]);
}

std::vector<Chart> datasetCharts(const Manifest& manifest, const DatasetSummary& summary) {
  return {classChart(summary), ringsChart(summary),
          stepsChart(summary,
                     {.name = "ranges",
                      .title = "Ranges",
                      .note = "m of distance from the sensor",
                      .x = {.title = "distance (m)"}},
                     summary.steps.step, [](const SensorSummary& sensor) { return sensor.ranges; }),
          intensitiesChart(summary), scanPointsChart(manifest)};
}

}  // namespace scanmill
