#include <algorithm>
#include <cmath>
#include <optional>

#include "evaluate/spread.h"
#include "study/compare/patches.h"

namespace scanmill {

namespace {

constexpr double kTurn = 2 * kPi;
// Points of a ring whose azimuths differ by less than this (rad) are returns of one beam.
constexpr double kLeastStep = kTurn / 8192;

// The indices of points in the scan, by ring.
using PointsOfRings = std::vector<std::vector<std::uint32_t>>;

double elevationOf(const Vec3f& p) {
  return std::atan2(static_cast<double>(p.z), std::hypot(static_cast<double>(p.x), static_cast<double>(p.y)));
}

// Builds the grid of a scan. One of three functions fills it: for known beams, for known rings, or for angles only.
class GridMaker {
 public:
  explicit GridMaker(const Scan& scan) : scan_(scan), azimuth_(scan.size()) {
    for (std::uint32_t i = 0; i < scan.size(); ++i) {
      const Vec3f& p = scan.position[i];
      if (!isFinite(p) || !(length(Vec3d(p)) > 0)) continue;
      points_.push_back(i);
      azimuth_[i] = std::atan2(static_cast<double>(p.y), static_cast<double>(p.x));
    }
  }

  RangeGrid make() {
    if (points_.empty()) return {};
    if (knowsBeams(scan_)) {
      fillByBeams();
    } else if (!scan_[kRing].empty()) {
      fillByRings();
    } else {
      fillByAngles();
    }
    return std::move(grid_);
  }

 private:
  void allocate(std::uint32_t rows, std::uint32_t columns) {
    grid_.rows = rows;
    grid_.columns = columns;
    const std::size_t size = std::size_t{rows} * columns;
    grid_.point.assign(size, RangeGrid::kNone);
    grid_.range.assign(size, std::numeric_limits<float>::quiet_NaN());
    grid_.returns.assign(size, 0);
  }

  // Counts a return of the pixel's beam, and keeps the point if it is the nearest of the beam.
  void addReturn(std::uint32_t row, std::uint32_t column, std::uint32_t point) {
    const std::size_t pixel = grid_.at(row, column);
    const auto range = static_cast<float>(length(Vec3d(scan_.position[point])));
    if (grid_.returns[pixel] < 255) ++grid_.returns[pixel];
    if (grid_.point[pixel] != RangeGrid::kNone && grid_.range[pixel] <= range) return;
    grid_.point[pixel] = point;
    grid_.range[pixel] = range;
  }

  // Returns the row of each ring. Rows follow the ring numbers, reversed if elevations rise with the numbers. The rows
  // of rings with points are then permuted such that the median elevations decrease downwards.
  std::vector<std::uint32_t> rowsOfRings(const PointsOfRings& ofRing) const {
    const auto rings = static_cast<std::uint32_t>(ofRing.size());
    std::vector<double> elevation(rings);  // median of each ring with points (rad)
    std::vector<std::uint32_t> filled;     // rings with points, ascending
    for (std::uint32_t r = 0; r < rings; ++r) {
      if (ofRing[r].empty()) continue;
      std::vector<double> elevations;
      for (const std::uint32_t i : ofRing[r]) elevations.push_back(elevationOf(scan_.position[i]));
      elevation[r] = medianOf(std::move(elevations));
      filled.push_back(r);
    }
    const bool upwards = filled.size() > 1 && elevation[filled.front()] < elevation[filled.back()];
    std::vector<std::uint32_t> row(rings);
    for (std::uint32_t r = 0; r < rings; ++r) row[r] = upwards ? rings - 1 - r : r;
    std::vector<std::uint32_t> rowsOfFilled;  // rows of the rings with points, from top to bottom
    for (const std::uint32_t r : filled) rowsOfFilled.push_back(row[r]);
    std::ranges::sort(rowsOfFilled);
    std::ranges::stable_sort(filled, [&](std::uint32_t a, std::uint32_t b) { return elevation[a] > elevation[b]; });
    for (std::size_t i = 0; i < filled.size(); ++i) row[filled[i]] = rowsOfFilled[i];
    return row;
  }

  // Returns the median azimuth step from column to column (rad); 0 if no neighbouring columns of a ring have points.
  double columnStep(const PointsOfRings& ofRing) const {
    std::vector<double> steps;
    for (const std::vector<std::uint32_t>& points : ofRing) {
      for (std::size_t k = 1; k < points.size(); ++k) {
        const auto previousColumn = static_cast<int>(keyOf(scan_, points[k - 1]).column);
        const auto column = static_cast<int>(keyOf(scan_, points[k]).column);
        if (column == previousColumn + 1)
          steps.push_back(std::remainder(azimuth_[points[k]] - azimuth_[points[k - 1]], kTurn));
      }
    }
    return medianOf(std::move(steps));
  }

  // Returns the azimuth of a ring's column 0 (rad): the median of the points' estimates. `step`: see columnStep().
  double firstAzimuth(const std::vector<std::uint32_t>& points, double step) const {
    const auto azimuthOfColumn0 = [&](std::uint32_t i) { return azimuth_[i] - step * keyOf(scan_, i).column; };
    const double estimate = azimuthOfColumn0(points[points.size() / 2]);
    std::vector<double> differences;
    for (const std::uint32_t i : points) differences.push_back(std::remainder(azimuthOfColumn0(i) - estimate, kTurn));
    return estimate + medianOf(std::move(differences));
  }

  // Fills the grid if the ring and the column of each point are known. The columns are those of the sensor; each ring
  // is shifted by whole columns to the azimuths of the first ring.
  void fillByBeams() {
    const PointKey extent = extentOf(scan_);
    const std::int64_t columns = std::max(scan_.columns, extent.column);
    PointsOfRings ofRing(std::max(scan_.rings, extent.ring));
    for (const std::uint32_t i : points_) ofRing[keyOf(scan_, i).ring].push_back(i);
    const double step = columnStep(ofRing);
    allocate(static_cast<std::uint32_t>(ofRing.size()), static_cast<std::uint32_t>(columns));
    grid_.knowsRings = grid_.knowsMisses = true;
    grid_.wraps = std::fabs(std::fabs(step) * static_cast<double>(columns) - kTurn) < 2 * std::fabs(step);
    const std::vector<std::uint32_t> row = rowsOfRings(ofRing);
    std::optional<double> reference;  // azimuth of column 0 in the first ring with points (rad)
    for (std::size_t r = 0; r < ofRing.size(); ++r) {
      if (ofRing[r].empty()) continue;
      const double azimuth = firstAzimuth(ofRing[r], step);
      if (!reference) reference = azimuth;
      const double shift = step == 0 ? 0 : std::round(std::remainder(azimuth - *reference, kTurn) / step);
      for (const std::uint32_t i : ofRing[r]) {
        const std::int64_t column = std::int64_t{keyOf(scan_, i).column} + static_cast<std::int64_t>(shift);
        if (!grid_.wraps && (column < 0 || column >= columns)) continue;
        addReturn(row[r], static_cast<std::uint32_t>(((column % columns) + columns) % columns), i);
      }
    }
  }

  // Returns the number of columns per revolution, from the median azimuth step between consecutive points of a ring;
  // 1024 if no ring has two points. `ofRing`: the points of each ring, sorted by azimuth.
  std::uint32_t columnsPerTurn(const PointsOfRings& ofRing) const {
    constexpr double kUsualColumns = 1024;  // used if no ring has two points
    std::vector<double> steps;
    for (const std::vector<std::uint32_t>& points : ofRing) {
      for (std::size_t k = 1; k < points.size(); ++k) {
        const double step = azimuth_[points[k]] - azimuth_[points[k - 1]];
        if (step >= kLeastStep) steps.push_back(step);
      }
    }
    const double step = medianOf(std::move(steps), kTurn / kUsualColumns);
    return static_cast<std::uint32_t>(std::max(1.0, std::round(kTurn / step)));
  }

  // Fills the grid if the ring of each point is known, but not its column. Sorts the points of a ring by azimuth and
  // finds the columns from the azimuths.
  void fillByRings() {
    const std::vector<std::uint16_t>& ring = scan_[kRing];
    PointsOfRings ofRing(std::max<std::uint32_t>(scan_.rings, *std::ranges::max_element(ring) + 1u));
    for (const std::uint32_t i : points_) ofRing[ring[i]].push_back(i);
    for (std::vector<std::uint32_t>& points : ofRing) {
      std::ranges::stable_sort(points, {}, [&](std::uint32_t i) { return azimuth_[i]; });
    }
    const std::uint32_t columns = columnsPerTurn(ofRing);
    // Azimuth (rad) of the middle of a column, modulo the width of a column.
    const double phase = circularMean(points_, [&](std::uint32_t i) { return azimuth_[i] * columns; }) / columns;
    allocate(static_cast<std::uint32_t>(ofRing.size()), columns);
    grid_.knowsRings = grid_.knowsMisses = grid_.wraps = true;
    const std::vector<std::uint32_t> row = rowsOfRings(ofRing);
    for (std::size_t r = 0; r < ofRing.size(); ++r) fillRow(row[r], ofRing[r], phase);
  }

  // Fills a row with the points of a ring, which are sorted by azimuth. `phase`: azimuth (rad) of the middle of a
  // column. Azimuths are noisy, so a rounded column may be wrong by one. A point that is less than 1.5 steps after the
  // previous point gets the column after the previous point's column.
  void fillRow(std::uint32_t row, const std::vector<std::uint32_t>& points, double phase) {
    const std::uint32_t columns = grid_.columns;
    const double step = kTurn / columns;
    std::int64_t previousColumn = -2;  // -2: there is no previous point
    double previousAzimuth = 0;
    for (const std::uint32_t i : points) {
      const double azimuth = azimuth_[i] + kPi - phase;
      auto column = static_cast<std::int64_t>(std::round(azimuth / step));
      if (previousColumn > -2) {
        if (azimuth - previousAzimuth < kLeastStep) {
          column = previousColumn;  // another return of the same beam
        } else if (column == previousColumn + 2 && azimuth - previousAzimuth < 1.5 * step) {
          column = previousColumn + 1;
        } else {
          column = std::max(column, previousColumn + 1);
        }
      }
      previousColumn = column;
      previousAzimuth = azimuth;
      addReturn(row, static_cast<std::uint32_t>((column + columns) % columns), i);
    }
  }

  // Fills the grid from azimuths and elevations if neither rings nor columns are known.
  void fillByAngles() {
    constexpr std::uint32_t kRows = 64, kColumns = 1024;
    constexpr double kOutliers = 0.005;  // fraction of the points that is ignored at the top, and at the bottom
    std::vector<double> elevations;
    for (const std::uint32_t i : points_) elevations.push_back(elevationOf(scan_.position[i]));
    std::vector<double> sorted = elevations;
    std::ranges::sort(sorted);
    const auto cut = static_cast<std::size_t>(kOutliers * static_cast<double>(sorted.size()));
    const double low = sorted[cut];
    const double high = sorted[sorted.size() - 1 - cut];
    allocate(kRows, kColumns);
    grid_.wraps = true;
    for (std::size_t k = 0; k < points_.size(); ++k) {
      if (elevations[k] < low || elevations[k] > high) continue;
      const double fromTop = high > low ? (high - elevations[k]) / (high - low) : 0;  // 0 to 1
      const auto row = static_cast<std::uint32_t>(std::min<double>(kRows - 1, fromTop * kRows));
      const double revolution = (azimuth_[points_[k]] + kPi) / kTurn;  // 0 to 1
      addReturn(row, static_cast<std::uint32_t>(std::min<double>(kColumns - 1, revolution * kColumns)), points_[k]);
    }
  }

  const Scan& scan_;
  std::vector<double> azimuth_;        // azimuth of each point (rad)
  std::vector<std::uint32_t> points_;  // indices of finite points
  RangeGrid grid_;
};

}  // namespace

std::uint32_t RangeGrid::beside(std::uint32_t row, std::uint32_t column, int steps) const {
  std::int64_t target = std::int64_t{column} + steps;
  if (target < 0 || target >= std::int64_t{columns}) {
    if (!wraps) return kNone;
    target = ((target % columns) + columns) % columns;
  }
  return static_cast<std::uint32_t>(at(row, static_cast<std::uint32_t>(target)));
}

RangeGrid rangeGrid(const Scan& scan) {
  return GridMaker(scan).make();
}

}  // namespace scanmill
