#include "report/dataset/dataset_tables.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "base/grouped.h"
#include "base/short_text.h"
#include "report/dataset/dataset_charts.h"
#include "report/page/report_html.h"
#include "scan/columns.h"
#include "study/figure_text.h"

namespace scanmill {

namespace {

constexpr double kDegrees = 180 / kPi;
constexpr std::size_t kMostRows = 2000;  // a browser shows more of them slowly

double ratio(double part, double whole) {
  return whole > 0 ? part / whole : 0;
}

HtmlCell wholeCell(std::uint64_t count) {
  return {grouped(count), static_cast<double>(count)};
}

HtmlCell partCell(std::uint64_t part, std::uint64_t whole) {
  const double share = ratio(static_cast<double>(part), static_cast<double>(whole));
  return {shareText(share), share};
}

HtmlCell bytesCell(std::uint64_t bytes) {
  return {shortBytes(static_cast<double>(bytes)), static_cast<double>(bytes), fmt::format("{} bytes", bytes)};
}

HtmlCell meanCell(std::uint64_t count, std::uint64_t of) {
  if (of == 0) return {};
  const double mean = static_cast<double>(count) / static_cast<double>(of);
  return {mean < 10 ? fmt::format("{:.2g}", mean) : amountText(mean), mean};
}

std::string finished(const HtmlTable& table) {
  return table.empty() ? "" : table.html();
}

std::string list(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string meaningOf(const std::string& name) {
  const std::size_t axis = std::string_view("xyz").find(name);
  if (name.size() == 1 && axis < 3)
    return fmt::format("m, sensor frame: {}", std::array{"forward", "left", "up"}[axis]);
  const std::size_t index = columnIndex(name);
  if (index == kColumnCount) return "";
  const Column& column = kColumns[index];
  return fmt::format("{}{}{}", column.unit, column.unit.empty() ? "" : ", ", column.meaning);
}

}  // namespace

std::string classesOverview(const DatasetSummary& summary) {
  const bool instances = summary.instanced && summary.labelled;
  HtmlTable table;
  table.column("class");
  table.column("id");
  table.column("points", "of all scans");
  table.column("share", "of all points");
  table.column("scans", "of all scans: those with the class");
  std::vector<std::string> splits;
  for (const SplitSummary& s : summary.splits) {
    if (s.samples > 0 && summary.splits.size() > 1) splits.push_back(s.name);
  }
  for (const std::string& split : splits) table.column(split, "points in the split");
  if (instances) {
    const std::string of = fmt::format(", in the {} read", pluralOf(summary.scansRead, "scan"));
    table.column("instances", "different ones with points of the class" + of);
    table.column("a scan", "instances in a scan's view" + of);
    table.column("points an instance", "of the class: median over instances in a scan" + of);
    table.column("without id", "points that have no instance" + of);
  }
  for (const ClassSummary& c : summary.classes) {
    if (c.points == 0) continue;
    std::vector<HtmlCell> cells{{c.name, std::nan(""), c.thing ? "countable: its objects have instance ids" : ""},
                                {std::to_string(c.id), double(c.id)},
                                wholeCell(c.points),
                                partCell(c.points, summary.points),
                                wholeCell(c.scans)};
    for (const std::string& split : splits) {
      const auto own = c.pointsOfSplit.find(split);
      cells.push_back(wholeCell(own == c.pointsOfSplit.end() ? 0 : own->second));
    }
    if (instances) {
      const bool counted = c.thing || c.objects > 0;
      cells.push_back(counted ? wholeCell(c.objects) : HtmlCell{});
      cells.push_back(counted ? meanCell(c.views, summary.scansRead) : HtmlCell{});
      cells.push_back(c.views > 0 ? HtmlCell{amountText(c.medianPoints), c.medianPoints} : HtmlCell{});
      cells.push_back(wholeCell(c.pointsWithoutId));
    }
    table.row(std::move(cells));
  }
  return finished(table);
}

std::string distancesOverview(const DatasetSummary& summary) {
  HtmlTable table;
  table.column("distance");
  table.column("points");
  table.column("share", "of the points read");
  table.column("points a scan");
  for (const SensorSummary& s : summary.sensors) {
    if (summary.sensors.size() > 1) table.column(s.name, "points a scan of this sensor");
  }
  for (const DistanceRing& ring : distanceRings(summary)) {
    const auto sum = [&](const SensorSummary& s) {
      return std::accumulate(s.ranges.begin() + static_cast<std::ptrdiff_t>(ring.first),
                             s.ranges.begin() + static_cast<std::ptrdiff_t>(ring.last), std::uint64_t{0});
    };
    std::uint64_t points = 0;
    for (const SensorSummary& s : summary.sensors) points += sum(s);
    std::vector<HtmlCell> cells{{ring.name, static_cast<double>(ring.first)},
                                wholeCell(points),
                                partCell(points, summary.pointsRead),
                                meanCell(points, summary.scansRead)};
    for (const SensorSummary& s : summary.sensors) {
      if (summary.sensors.size() > 1) cells.push_back(meanCell(sum(s), s.scansRead));
    }
    table.row(std::move(cells));
  }
  return finished(table);
}

std::string reasonsOverview(const DatasetSummary& summary) {
  HtmlTable table;
  table.column("reason");
  table.column("colour in the images", "", true);
  for (const SensorSummary& s : summary.sensors) {
    if (s.beamsPerReason.empty()) continue;
    table.column(fmt::format("{}: beams", s.name));
    table.column("share");
  }
  table.column("meaning", "", true);
  bool any = false;
  for (const ReasonEntry& r : reasons()) {
    std::vector<HtmlCell> cells{{std::string(r.name)},
                                {fmt::format("#{:02x}{:02x}{:02x}", r.color[0], r.color[1], r.color[2])}};
    std::uint64_t all = 0;
    for (const SensorSummary& s : summary.sensors) {
      if (s.beamsPerReason.empty()) continue;
      std::uint64_t beams = 0;
      for (const auto& [reason, count] : s.beamsPerReason) beams += count;
      const auto own = s.beamsPerReason.find(static_cast<std::uint8_t>(r.reason));
      const std::uint64_t count = own == s.beamsPerReason.end() ? 0 : own->second;
      cells.push_back(wholeCell(count));
      cells.push_back(partCell(count, beams));
      all += count;
    }
    if (all == 0) continue;
    cells.push_back({std::string(r.meaning)});
    table.row(std::move(cells));
    any = true;
  }
  return any ? finished(table) : "";
}

std::string objectsOverview(const Manifest& manifest, const ObjectCounts& counts) {
  if (counts.ofClass.empty()) return "";
  const auto tableOf = [&](const char* first, const auto& addRows) {
    HtmlTable table;
    table.column(first);
    table.column("views");
    for (const char* step : kVisibilitySteps) table.column(step);
    addRows([&](const std::string& name, const VisibilityCounts& own) {
      const std::uint64_t all = std::accumulate(own.begin(), own.end(), std::uint64_t{0});
      if (all == 0) return;
      std::vector<HtmlCell> cells{{name}, wholeCell(all)};
      for (const std::uint64_t count : own) cells.push_back(partCell(count, all));
      table.row(std::move(cells));
    });
    return finished(table);
  };
  const std::string byClass = tableOf("class", [&](const auto& add) {
    for (const auto& [id, own] : counts.ofClass) add(manifest.ontology.find(id)->name, own);
  });
  const std::string byDistance = tableOf("distance", [&](const auto& add) {
    for (std::size_t i = 0; i < counts.ofDistance.size(); ++i) {
      const double from = i == 0 ? 0 : kDistanceSteps[i - 1];
      add(i < kDistanceSteps.size() ? fmt::format("{} to {} m", from, kDistanceSteps[i])
                                    : fmt::format("from {} m", from),
          counts.ofDistance[i]);
    }
  });
  return byClass + byDistance;
}

std::string sensorsOverview(const Manifest& manifest, const DatasetSummary& summary) {
  HtmlTable table;
  for (const char* title :
       {"sensor", "model", "rings x columns", "range (m)", "elevation (\xC2\xB0)", "field (\xC2\xB0)", "revolution (s)",
        "mount: x, y, z (m)", "yaw, pitch, roll (\xC2\xB0)"}) {
    table.column(title);
  }
  table.column("method", "", true);
  for (const char* title : {"scans", "points a scan", "points a beam"}) table.column(title);
  table.column("source of the figures", "", true);
  for (std::size_t i = 0; i < manifest.sensors.size(); ++i) {
    const SensorRecord& s = manifest.sensors[i];
    const SensorSummary& sum = summary.sensors[i];
    const BeamTable& b = s.beams;
    const auto ends = std::minmax_element(b.elevation.begin(), b.elevation.end());
    const Quat& q = s.vehicleFromSensor.rotation;
    const Vec3d& t = s.vehicleFromSensor.translation;
    // The inverse of fromYawPitchRoll().
    const double yaw = std::atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z));
    const double pitch = std::asin(std::clamp(2 * (q.w * q.y - q.z * q.x), -1.0, 1.0));
    const double roll = std::atan2(2 * (q.w * q.x + q.y * q.z), 1 - 2 * (q.x * q.x + q.y * q.y));
    table.row(
        {{s.name},
         {b.model},
         {fmt::format("{} x {}", b.rings, b.columns), static_cast<double>(b.size())},
         {fmt::format("{:g} to {:g}", b.minRange, b.maxRange), b.maxRange},
         b.elevation.empty()
             ? HtmlCell{}
             : HtmlCell{fmt::format("{:.4g} to {:.4g}", *ends.first * kDegrees, *ends.second * kDegrees)},
         {fmt::format("{:.4g}", b.field * kDegrees), b.field},
         {fmt::format("{:g}", b.period), b.period},
         {fmt::format("{:g}, {:g}, {:g}", t.x, t.y, t.z)},
         {fmt::format("{:.3g}, {:.3g}, {:.3g}", yaw * kDegrees + 0.0, pitch * kDegrees + 0.0, roll * kDegrees + 0.0)},
         {list(sum.methods)},
         wholeCell(sum.scans),
         meanCell(sum.points, sum.scans),
         partCell(sum.points, sum.beams),
         {b.source}});
  }
  return finished(table);
}

std::string sequencesOverview(const DatasetSummary& summary) {
  HtmlTable table;
  for (const char* title : {"sequence", "scene"}) table.column(title, "", true);
  table.column("seed");
  for (const char* title : {"trajectory", "split"}) table.column(title, "", true);
  for (const char* title : {"samples", "scans", "points", "points a scan", "time (s)"}) table.column(title);
  for (std::size_t i = 0; i < std::min(summary.sequences.size(), kMostRows); ++i) {
    const SequenceSummary& s = summary.sequences[i];
    table.row({{s.name},
               {s.scene},
               {s.seed},
               {s.trajectory},
               {s.split},
               wholeCell(s.samples),
               wholeCell(s.scans),
               wholeCell(s.points),
               meanCell(s.points, s.scans),
               {fmt::format("{:.4g}", s.seconds), s.seconds}});
  }
  const std::string more =
      summary.sequences.size() > kMostRows
          ? htmlParagraph(fmt::format("The first {} of {}.", kMostRows, pluralOf(summary.sequences.size(), "sequence")))
          : "";
  return finished(table) + more;
}

std::string splitsOverview(const DatasetSummary& summary) {
  HtmlTable table;
  for (const char* title : {"split", "samples", "share", "scans", "points", "shards", "size"}) table.column(title);
  for (const SplitSummary& s : summary.splits) {
    table.row({{s.name},
               wholeCell(s.samples),
               partCell(s.samples, summary.samples),
               wholeCell(s.scans),
               wholeCell(s.points),
               wholeCell(s.shards),
               bytesCell(s.bytes)});
  }
  return finished(table);
}

std::string shardsOverview(const Manifest& manifest, const std::vector<std::string>& faults) {
  constexpr std::size_t kHashShown = 12;
  HtmlTable table;
  for (const char* title : {"shard", "split", "samples", "size"}) table.column(title);
  for (const char* title : {"SHA-256", "state"}) table.column(title, "", true);
  const std::size_t shown = std::min(manifest.shards.size(), kMostRows);
  for (std::size_t i = 0; i < shown; ++i) {
    const ShardRecord& s = manifest.shards[i];
    table.row({{s.file},
               {s.split},
               wholeCell(s.samples),
               bytesCell(s.bytes),
               {s.sha256.substr(0, kHashShown), std::nan(""), s.sha256},
               {faults[i].empty() ? "as the manifest says" : faults[i]}});
  }
  const std::string more = manifest.shards.size() > shown
                               ? htmlParagraph(fmt::format("The first {} of {} shards.", shown, manifest.shards.size()))
                               : "";
  return finished(table) + more;
}

std::string columnsOverview(const Manifest& manifest) {
  HtmlTable table;
  table.column("column");
  table.column("what it is", "", true);
  for (const std::string& column : manifest.columns) table.row({{column}, {meaningOf(column)}});
  return finished(table);
}

std::string formatsOverview(const Manifest& manifest) {
  HtmlTable table;
  for (const char* title : {"format", "suffix", "largest error of a position"}) table.column(title);
  for (const FormatRecord& f : manifest.formats) {
    table.row(
        {{f.name}, {"." + f.suffix}, {f.maxErrorMetres > 0 ? metresText(f.maxErrorMetres) : "none", f.maxErrorMetres}});
  }
  return finished(table);
}

std::string mixedInstances(const DatasetSummary& summary) {
  std::map<std::string, std::uint64_t> groups;
  for (const MixedInstance& m : summary.mixed) {
    if (!m.usual) continue;
    std::vector<std::string> names;
    for (const ClassSummary& c : summary.classes) {
      if (m.pointsOfClass.contains(c.id)) names.push_back(c.name);
    }
    ++groups[list(names)];
  }
  HtmlTable table;
  table.column("classes of one instance");
  table.column("instances");
  for (const auto& [names, count] : groups) table.row({{names}, wholeCell(count)});
  return finished(table);
}

}  // namespace scanmill
