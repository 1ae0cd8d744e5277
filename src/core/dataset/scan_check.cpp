#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_set>

#include "dataset/verify.h"

namespace scanmill {

namespace {

// Largest range of a valid point, as a multiple of the sensor's maximum range. Noise may move a point beyond the
// maximum range: the `shell` effect by half the range, Gaussian noise in principle without limit.
constexpr double kNoiseReach = 1.5;
// Largest relative rounding error of ranges, which are stored in float32 or in CSV's decimal digits.
constexpr double kRangeRounding = 1e-5;

// Counts the points that break a rule, and stores the first of them.
class Rule {
 public:
  // `violation`: what is wrong with a point; follows "points" in the message: "not finite", "with a ring above 63".
  explicit Rule(std::string violation) : violation_(std::move(violation)) {}
  void check(bool isKept, std::size_t point) {
    if (isKept) return;
    if (violations_++ == 0) firstPoint_ = point;
  }
  // Appends a line to `problems` if any point breaks the rule.
  void report(std::vector<std::string>& problems) const {
    if (violations_ == 0) return;
    problems.push_back(fmt::format("{} point{} {} (the first is point {})", violations_, violations_ == 1 ? "" : "s",
                                   violation_, firstPoint_));
  }

 private:
  std::string violation_;
  std::size_t violations_ = 0;
  std::size_t firstPoint_ = 0;
};

// Checks one scan. The manifest must list the record's sensor.
class ScanCheck {
 public:
  ScanCheck(const Scan& scan, const ScanRecord& record, const Manifest& manifest, double maxError)
      : scan_(scan),
        record_(record),
        manifest_(manifest),
        beams_(std::ranges::find(manifest.sensors, record.sensor, &SensorRecord::name)->beams),
        maxError_(maxError) {}

  std::vector<std::string> run() {
    checkShape();
    if (problems_.empty()) {
      checkPositions();
      visitTable(scan_, [&](auto key, const auto& values) {
        if (!values.empty()) checkColumn(key.row, values);
      });
      checkClasses();
      checkInstances();
    }
    return std::move(problems_);
  }

 private:
  template <class... Parts>
  void problem(fmt::format_string<Parts...> text, Parts&&... parts) {
    problems_.push_back(fmt::format(text, std::forward<Parts>(parts)...));
  }

  // Returns true if a point is a miss. Only organised scans have misses. The manifest states whether the scan is
  // organised, because a CSV file does not state it.
  bool isMiss(std::size_t i) const {
    const Vec3f& p = scan_.position[i];
    return manifest_.organised && std::isnan(p.x) && std::isnan(p.y) && std::isnan(p.z);
  }

  void checkShape() {
    if (record_.beams != beams_.size()) problem("{} beams, but its sensor has {}", record_.beams, beams_.size());
    if (scan_.organised && scan_.size() != scan_.planes * beams_.size()) {
      problem("{} x {} points, but its sensor has {} rings of {} columns", scan_.height(), scan_.width(), beams_.rings,
              beams_.columns);
    }
    checkColumns();
  }

  // Compares the scan's columns with the columns in the manifest. A format may leave out the column `time`, because the
  // times can be computed from ring, column and beam table.
  void checkColumns() {
    const std::vector<std::string> scanColumns = columnNames(scan_);
    const auto contains = [](const std::vector<std::string>& names, const std::string& name) {
      return std::ranges::find(names, name) != names.end();
    };
    for (const std::string& name : scanColumns) {
      if (!contains(manifest_.columns, name))
        problem("the scan has the column {}, but the manifest does not list it", name);
    }
    for (const std::string& name : manifest_.columns) {
      if (!contains(scanColumns, name) && name != kTime.row.name)
        problem("the scan has no column {}, but the manifest lists it", name);
    }
  }

  // Checks that the points are finite and within the sensor's reach, and counts them.
  void checkPositions() {
    const auto largest = [](const std::vector<double>& offsets) {
      double magnitude = 0;
      for (const double offset : offsets) magnitude = std::max(magnitude, std::abs(offset));
      return magnitude;
    };
    // Distance (m) between the first and the last pose: deskewed points are in the frame of the first pose.
    const double motion =
        length(record_.worldFromSensor.back().translation - record_.worldFromSensor.front().translation);
    // Largest valid distance (m) from the origin of the sensor's frame. Beams may start away from this origin.
    const double reach = kNoiseReach * beams_.maxRange + std::hypot(beams_.originOffset, beams_.originHeight) +
                         std::hypot(largest(beams_.originLeft), largest(beams_.originUp)) + motion + maxError_;
    Rule finiteRule("not finite");
    Rule reachRule(fmt::format("farther than {:.6g} m, the sensor's greatest range", reach));
    std::uint64_t points = 0;
    for (std::size_t i = 0; i < scan_.size(); ++i) {
      if (isMiss(i)) continue;
      ++points;
      const bool finite = isFinite(scan_.position[i]);
      finiteRule.check(finite, i);
      if (finite) reachRule.check(length(static_cast<Vec3d>(scan_.position[i])) <= reach, i);
    }
    finiteRule.report(problems_);
    reachRule.report(problems_);
    if (points != record_.points) problem("{} points, but the manifest says {}", points, record_.points);
  }

  // Reports the values that the column's validity in the table of columns does not allow.
  template <class T>
  void checkColumn(const Column& column, const std::vector<T>& values) {
    // Reports the points for which isValid(index of the point, value) is false.
    const auto check = [&](const std::string& violation, const auto& isValid) {
      Rule rule(violation);
      for (std::size_t i = 0; i < values.size(); ++i) rule.check(isValid(i, static_cast<double>(values[i])), i);
      rule.report(problems_);
    };
    const auto checkBelow = [&](std::uint32_t count) {
      check(fmt::format("with a {} above {}", column.name, count - 1),
            [&](std::size_t, double value) { return value < count; });
    };
    switch (column.validity) {
      case ColumnValidity::Any:
        return;
      case ColumnValidity::Finite:
        return check(fmt::format("with {} not finite", column.name),
                     [](std::size_t, double value) { return std::isfinite(value); });
      case ColumnValidity::Rings:
        return checkBelow(beams_.rings);
      case ColumnValidity::Columns:
        return checkBelow(beams_.columns);
      case ColumnValidity::SensorRange: {
        const double tolerance = maxError_ + kRangeRounding * beams_.maxRange;  // m
        return check(fmt::format("with {} outside {:.6g} to {:.6g} m", column.name, beams_.minRange, beams_.maxRange),
                     [&](std::size_t i, double value) {
                       // Points that come from no surface have no range. Without the column `cause` any may be such.
                       const bool isOfSurface =
                           !scan_[kCause].empty() && scan_[kCause][i] == static_cast<std::uint8_t>(Reason::Surface);
                       return isMiss(i) || (std::isnan(value) && !isOfSurface) ||
                              (value >= beams_.minRange - tolerance && value <= beams_.maxRange + tolerance);
                     });
      }
      case ColumnValidity::Interval: {
        // Twice the largest error that a lossy format may cause, plus the error of rounding a bound to float32.
        const double tolerance = 2 * column.lossBound + 1e-6 * std::max(std::abs(column.low), std::abs(column.high));
        return check(
            fmt::format("with {} outside {:.6g} to {:.6g} {}", column.name, column.low, column.high, column.unit),
            [&](std::size_t, double value) {
              return std::isnan(value) || (value >= column.low - tolerance && value <= column.high + tolerance);
            });
      }
    }
  }

  // Compares the number of points of each class with the manifest.
  void checkClasses() {
    if (scan_[kLabel].empty()) return;
    std::map<std::uint16_t, std::uint64_t> counts;
    for (std::size_t i = 0; i < scan_.size(); ++i) {
      if (!isMiss(i)) ++counts[scan_[kLabel][i]];
    }
    for (const auto& [id, points] : counts) {
      const SemanticClass* const semantic = manifest_.ontology.find(id);
      if (semantic == nullptr) {
        problem("{} points of class {}, which is not in the ontology '{}'", points, id, manifest_.ontology.name);
        continue;
      }
      const auto entry = record_.pointsPerClass.find(id);
      const std::uint64_t expected = entry == record_.pointsPerClass.end() ? 0 : entry->second;
      if (points != expected) problem("{} points of {}, but the manifest says {}", points, semantic->name, expected);
    }
    for (const auto& [id, expected] : record_.pointsPerClass) {
      if (expected == 0 || counts.contains(id)) continue;
      problem("no points of {}, but the manifest says {}", manifest_.ontology.find(id)->name, expected);
    }
  }

  // Compares the number of distinct instances with the manifest.
  void checkInstances() {
    if (scan_[kInstance].empty()) return;
    std::unordered_set<std::uint32_t> instances;
    std::uint32_t previousId = 0;  // spares most insertions: neighbouring points mostly belong to the same object
    for (const std::uint32_t id : scan_[kInstance]) {
      if (id != previousId && id != 0) instances.insert(id);
      previousId = id;
    }
    if (instances.size() != record_.instances) {
      problem("{} instances, but the manifest says {}", instances.size(), record_.instances);
    }
  }

  const Scan& scan_;
  const ScanRecord& record_;
  const Manifest& manifest_;
  const BeamTable& beams_;
  double maxError_;
  std::vector<std::string> problems_;
};

}  // namespace

std::vector<std::string> checkScan(const Scan& scan, const ScanRecord& record, const Manifest& manifest,
                                   double maxError) {
  return ScanCheck(scan, record, manifest, maxError).run();
}

}  // namespace scanmill
