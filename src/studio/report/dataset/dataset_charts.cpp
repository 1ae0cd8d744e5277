#include "report/dataset/dataset_charts.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "charts/chart.h"
#include "study/figure_text.h"

namespace scanmill {

namespace {

constexpr int kHalfWidth = 575, kWholeWidth = 1150;  // pixels of charts, side by side and alone in a row
constexpr int kBarHeight = 21, kAround = 120;
constexpr std::size_t kMostClasses = 12;  // of a stacked bar
constexpr const char* kOtherFill = "#8b949e";

double perScan(std::uint64_t points, std::uint64_t scans) {
  return scans == 0 ? 0 : static_cast<double>(points) / static_cast<double>(scans);
}

std::uint64_t sumOf(const std::vector<std::uint64_t>& counts, std::size_t first, std::size_t last) {
  return std::accumulate(counts.begin() + static_cast<std::ptrdiff_t>(first),
                         counts.begin() + static_cast<std::ptrdiff_t>(last), std::uint64_t{0});
}

// The most frequent first.
std::vector<const ClassSummary*> classesWith(const DatasetSummary& summary,
                                             const std::function<std::uint64_t(const ClassSummary&)>& count) {
  std::vector<const ClassSummary*> classes;
  for (const ClassSummary& c : summary.classes) {
    if (count(c) > 0) classes.push_back(&c);
  }
  std::stable_sort(classes.begin(), classes.end(), [&](const auto* a, const auto* b) { return count(*a) > count(*b); });
  return classes;
}

std::string ofScans(const DatasetSummary& summary) {
  return summary.scansRead == summary.scans ? fmt::format("of all {}", pluralOf(summary.scans, "scan"))
                                            : fmt::format("of {} of {} scans", summary.scansRead, summary.scans);
}

std::vector<std::uint64_t> sumOfSensors(const DatasetSummary& summary) {
  std::vector<std::uint64_t> all(summary.steps.count, 0);
  for (const SensorSummary& s : summary.sensors) {
    for (std::size_t k = 0; k < all.size(); ++k) all[k] += s.ranges[k];
  }
  return all;
}

// Bars of distance rings, stacked by class: points a scan, or shares of the ring.
std::string ringsChartOf(const DatasetSummary& summary, bool shares) {
  const std::vector<DistanceRing> rings = distanceRings(summary);
  if (rings.empty()) return "";
  const std::vector<std::uint64_t> all = sumOfSensors(summary);
  Chart chart{.title = shares ? "Classes in each ring of distance" : "Points per ring of distance",
              .note = fmt::format("from the sensor; {}{}", shares ? "" : "a scan's mean, ", ofScans(summary))};
  chart.stacked = true;
  chart.y = {.title = shares ? "share of the ring's points" : "points a scan", .unit = shares ? "%" : ""};
  if (shares) chart.y.high = 1;
  for (const DistanceRing& ring : rings) chart.x.names.push_back(ring.name);
  std::vector<double> stacked(rings.size(), 0.0);
  const auto add = [&](const std::string& name, const std::string& fill, const std::vector<std::uint64_t>& ranges) {
    ChartSeries bars{.name = name, .mark = ChartMark::Bars};
    for (std::size_t i = 0; i < rings.size(); ++i) {
      const std::uint64_t points = sumOf(ranges, rings[i].first, rings[i].last);
      double value = perScan(points, shares ? sumOf(all, rings[i].first, rings[i].last) : summary.scansRead);
      if (shares) value = std::min(value, 1 - stacked[i]);  // rounding must not lift the bar's end above 100 %
      stacked[i] += value;
      bars.points.push_back({static_cast<double>(i), value});
      bars.details.push_back(fmt::format("{}, {}: {}", name, rings[i].name,
                                         shares ? shareText(value) : amountText(value) + " points a scan"));
      if (!fill.empty()) bars.fills.push_back(fill);
    }
    chart.series.push_back(std::move(bars));
  };
  if (summary.labelled) {
    const auto classes =
        classesWith(summary, [](const ClassSummary& c) { return sumOf(c.ranges, 0, c.ranges.size()); });
    std::vector<std::uint64_t> others(summary.steps.count, 0);
    for (std::size_t i = 0; i < classes.size(); ++i) {
      if (i < kMostClasses || classes.size() == kMostClasses + 1) {
        add(classes[i]->name, htmlColor(classes[i]->color), classes[i]->ranges);
      } else {
        for (std::size_t k = 0; k < others.size(); ++k) others[k] += classes[i]->ranges[k];
      }
    }
    if (classes.size() > kMostClasses + 1) add("other classes", kOtherFill, others);
  } else {
    add("points", "", all);
  }
  chart.width = kHalfWidth;
  chart.height = 420;
  return drawSvg(chart);
}

}  // namespace

std::string htmlColor(const Rgb& color) {
  return fmt::format("#{:02x}{:02x}{:02x}", color[0], color[1], color[2]);
}

std::vector<DistanceRing> distanceRings(const DatasetSummary& summary) {
  const std::size_t count = summary.steps.count;
  std::size_t last = 0;
  for (const SensorSummary& s : summary.sensors) {
    for (std::size_t i = 0; i < s.ranges.size(); ++i) {
      if (s.ranges[i] > 0) last = std::max(last, i + 1);
    }
  }
  // Narrow ones near the sensor, where most points are; the last step has no end.
  std::vector<std::size_t> ends;
  for (const std::size_t end : {5, 10, 20, 30, 40, 50, 60, 80, 100}) {
    if (end < count - 1) ends.push_back(end);
  }
  ends.insert(ends.end(), {count - 1, count});
  std::vector<DistanceRing> rings;
  for (std::size_t first = 0, i = 0; first < last; first = ends[i++]) {
    const double from = static_cast<double>(first) * summary.steps.step;
    const double to = static_cast<double>(ends[i]) * summary.steps.step;
    rings.push_back({ends[i] == count ? fmt::format("from {:g} m", from) : fmt::format("{:g} to {:g} m", from, to),
                     first, ends[i]});
  }
  return rings;
}

std::string classPointsChart(const DatasetSummary& summary) {
  const auto classes = classesWith(summary, [](const ClassSummary& c) { return c.points; });
  if (classes.empty()) return "";
  Chart chart{.title = "Points per class", .note = "of all scans"};
  // With room for the labels of the longest bars.
  chart.x = {.title = "points", .scale = AxisScale::Log, .high = 4 * static_cast<double>(classes.front()->points)};
  ChartSeries bars{.name = "", .mark = ChartMark::Bars};
  for (const ClassSummary* c : classes) {
    bars.points.push_back({static_cast<double>(c->points), static_cast<double>(chart.y.names.size())});
    bars.labels.push_back(shareText(perScan(c->points, summary.points)));
    bars.details.push_back(fmt::format("{}: {} points", c->name, c->points));
    bars.fills.push_back(htmlColor(c->color));
    chart.y.names.push_back(c->name);
  }
  chart.series.push_back(std::move(bars));
  chart.width = kHalfWidth;
  chart.height = kAround + kBarHeight * static_cast<int>(classes.size());
  return drawSvg(chart);
}

std::string classObjectsChart(const DatasetSummary& summary) {
  const auto classes = classesWith(summary, [](const ClassSummary& c) { return c.objects; });
  if (classes.empty()) return "";
  Chart chart{.title = "Instances per class",
              .note = fmt::format("different ones, {}; an instance counts once in a sequence, for each of its classes",
                                  ofScans(summary))};
  chart.y.title = "instances";
  ChartSeries bars{.name = "", .mark = ChartMark::Bars};
  for (const ClassSummary* c : classes) {
    bars.points.push_back({static_cast<double>(chart.x.names.size()), static_cast<double>(c->objects)});
    bars.labels.push_back(std::to_string(c->objects));
    bars.details.push_back(fmt::format("{}: {}", c->name, c->objects));
    bars.fills.push_back(htmlColor(c->color));
    chart.x.names.push_back(c->name);
  }
  chart.series.push_back(std::move(bars));
  chart.width = kWholeWidth;
  chart.height = 320;
  return drawSvg(chart);
}

std::string splitSharesChart(const DatasetSummary& summary) {
  std::vector<const SplitSummary*> splits;
  for (const SplitSummary& s : summary.splits) {
    if (s.points > 0) splits.push_back(&s);
  }
  const auto classes = classesWith(summary, [](const ClassSummary& c) { return c.points; });
  if (splits.size() < 2 || classes.empty()) return "";
  Chart chart{.title = "Share of each class in the splits", .note = "of a split's points; of all scans"};
  chart.x = {.title = "share of points", .scale = AxisScale::Log, .unit = "%", .high = 1, .zero = "none"};
  for (std::size_t i = 0; i < splits.size(); ++i) {
    ChartSeries dots{.name = splits[i]->name, .color = i};
    for (std::size_t row = 0; row < classes.size(); ++row) {
      const auto own = classes[row]->pointsOfSplit.find(splits[i]->name);
      const double share = own == classes[row]->pointsOfSplit.end() ? 0 : perScan(own->second, splits[i]->points);
      dots.points.push_back({share, static_cast<double>(row)});
      dots.details.push_back(fmt::format("{} in {}: {}", classes[row]->name, splits[i]->name, shareText(share)));
    }
    chart.series.push_back(std::move(dots));
  }
  for (const ClassSummary* c : classes) chart.y.names.push_back(c->name);
  chart.width = kHalfWidth;
  chart.height = kAround + 30 + kBarHeight * static_cast<int>(classes.size());
  return drawSvg(chart);
}

std::string ringPointsChart(const DatasetSummary& summary) {
  return ringsChartOf(summary, false);
}

std::string ringSharesChart(const DatasetSummary& summary) {
  return summary.labelled ? ringsChartOf(summary, true) : "";
}

std::string rangesChart(const DatasetSummary& summary) {
  Chart chart{.title = "Ranges",
              .note = fmt::format("points per {:g} m of distance from the sensor; a scan's mean, {}",
                                  summary.steps.step, ofScans(summary))};
  chart.x = {.title = "distance (m)", .low = 0};
  chart.y = {.title = "points a scan", .scale = AxisScale::Log};
  for (std::size_t s = 0; s < summary.sensors.size(); ++s) {
    const SensorSummary& sensor = summary.sensors[s];
    ChartSeries line{.name = sensor.name, .color = s, .mark = ChartMark::Line};
    for (std::size_t i = 0; i < sensor.ranges.size(); ++i) {
      const double middle = (static_cast<double>(i) + 0.5) * summary.steps.step;
      const double points = perScan(sensor.ranges[i], sensor.scansRead);
      line.points.push_back({middle, sensor.ranges[i] == 0 ? NAN : points});
    }
    if (sensor.scansRead > 0) chart.series.push_back(std::move(line));
  }
  if (chart.series.empty()) return "";
  chart.width = kHalfWidth;
  chart.height = 360;
  return drawSvg(chart);
}

std::string intensitiesChart(const DatasetSummary& summary) {
  constexpr int kBins = 128;
  float most = 0;
  for (const SensorSummary& s : summary.sensors) {
    if (!s.intensities.empty()) most = std::max(most, intensityOfKey(s.intensities.rbegin()->first));
  }
  // A power of two: its bins' ends are ends of keys too, so that each key lies in one bin.
  const double high = most > 0 ? std::exp2(std::floor(std::log2(double{most})) + 1) : 1;
  Chart chart{.title = "Intensities",
              .note = fmt::format("points per {:g} of intensity; a scan's mean, {}", high / kBins, ofScans(summary))};
  chart.x = {.title = "intensity", .low = 0};
  chart.y = {.title = "points a scan", .scale = AxisScale::Log};
  for (std::size_t s = 0; s < summary.sensors.size(); ++s) {
    const SensorSummary& sensor = summary.sensors[s];
    if (sensor.intensities.empty()) continue;
    std::vector<std::uint64_t> bins(kBins, 0);
    for (const auto& [key, points] : sensor.intensities) {
      const double place = std::clamp(double{intensityOfKey(key)} / high, 0.0, 1.0) * kBins;
      bins[std::min(static_cast<std::size_t>(place), bins.size() - 1)] += points;
    }
    ChartSeries line{.name = sensor.name, .color = s, .mark = ChartMark::Line};
    for (std::size_t i = 0; i < bins.size(); ++i) {
      const double middle = (static_cast<double>(i) + 0.5) * high / kBins;
      line.points.push_back({middle, bins[i] == 0 ? NAN : perScan(bins[i], sensor.scansRead)});
    }
    chart.series.push_back(std::move(line));
  }
  if (chart.series.empty()) return "";
  chart.width = kHalfWidth;
  chart.height = 360;
  return drawSvg(chart);
}

std::string scanPointsChart(const Manifest& manifest) {
  constexpr std::size_t kMostMarks = 400;
  const std::size_t together = (manifest.samples.size() + kMostMarks - 1) / kMostMarks;
  Chart chart{.title = "Points a scan",
              .note = together > 1 ? fmt::format("in the order of the samples; the mean of {} each", together)
                                   : "in the order of the samples"};
  chart.x = {.title = "sample"};
  chart.y = {.title = "points", .low = 0};
  for (std::size_t s = 0; s < manifest.sensors.size(); ++s) {
    ChartSeries line{.name = manifest.sensors[s].name, .color = s, .mark = ChartMark::LineAndDots};
    if (manifest.samples.size() > 80) line.mark = ChartMark::Line;
    for (std::size_t first = 0; first < manifest.samples.size(); first += together) {
      const std::size_t last = std::min(first + together, manifest.samples.size());
      std::uint64_t points = 0, scans = 0;
      for (std::size_t i = first; i < last; ++i) {
        for (const ScanRecord& scan : manifest.samples[i].scans) {
          if (scan.sensor != manifest.sensors[s].name) continue;
          points += scan.points;
          ++scans;
        }
      }
      line.points.push_back({static_cast<double>(first), scans == 0 ? NAN : perScan(points, scans)});
      line.details.push_back(fmt::format("{}: {}", manifest.samples[first].key, points));
    }
    chart.series.push_back(std::move(line));
  }
  if (manifest.samples.empty()) return "";
  chart.width = kWholeWidth;
  chart.height = 300;
  return drawSvg(chart);
}

}  // namespace scanmill
