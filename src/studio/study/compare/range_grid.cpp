#include "study/compare/range_grid.h"

#include <algorithm>
#include <cmath>

#include "evaluate/spread.h"

namespace scanmill {

namespace {

constexpr double kTurn = 2 * kPi;

double azimuthOf(const Vec3f& p) {
  return std::atan2(static_cast<double>(p.y), static_cast<double>(p.x));
}

double elevationOf(const Vec3f& p) {
  return std::atan2(static_cast<double>(p.z), std::hypot(static_cast<double>(p.x), static_cast<double>(p.y)));
}

class GridMaker {
 public:
  explicit GridMaker(const Scan& scan) : scan_(scan) {
    for (std::uint32_t i = 0; i < scan.size(); ++i) {
      const Vec3f& p = scan.position[i];
      if (isFinite(p) && length(Vec3d(p)) > 0) points_.push_back(i);
    }
  }

  RangeGrid make() {
    if (points_.empty()) return {};
    if (knowsBeams(scan_)) {
      byBeams();
    } else if (!scan_[kRing].empty()) {
      byRings();
    } else {
      byAngles();
    }
    return std::move(grid_);
  }

 private:
  void start(std::uint32_t rows, std::uint32_t columns) {
    grid_.rows = rows;
    grid_.columns = columns;
    const std::size_t size = std::size_t{rows} * columns;
    grid_.point.assign(size, RangeGrid::kNone);
    grid_.range.assign(size, std::numeric_limits<float>::quiet_NaN());
    grid_.returns.assign(size, 0);
  }

  void put(std::uint32_t row, std::uint32_t column, std::uint32_t point) {
    const std::size_t pixel = grid_.at(row, column);
    const auto range = static_cast<float>(length(Vec3d(scan_.position[point])));
    if (grid_.returns[pixel] < 255) ++grid_.returns[pixel];
    if (grid_.point[pixel] != RangeGrid::kNone && grid_.range[pixel] <= range) return;
    grid_.point[pixel] = point;
    grid_.range[pixel] = range;
  }

  // Returns the row of each ring. Rings with points are sorted from top to bottom by the median elevation of their
  // points. Rings without points get the row that follows from their ring number.
  std::vector<std::uint32_t> rowsOfRings(const std::vector<std::vector<std::uint32_t>>& pointsOfRing) const {
    std::vector<double> elevation(pointsOfRing.size(), std::numeric_limits<double>::quiet_NaN());
    std::vector<double> own;
    std::vector<std::uint32_t> filled;
    for (std::uint32_t r = 0; r < pointsOfRing.size(); ++r) {
      own.clear();
      for (const std::uint32_t i : pointsOfRing[r]) own.push_back(elevationOf(scan_.position[i]));
      if (own.empty()) continue;
      elevation[r] = medianOf(own);
      filled.push_back(r);
    }
    std::vector<std::uint32_t> sorted = filled;
    std::ranges::stable_sort(sorted, [&](std::uint32_t a, std::uint32_t b) { return elevation[a] > elevation[b]; });
    const bool upwards = filled.size() > 1 && elevation[filled.front()] < elevation[filled.back()];
    std::vector<std::uint32_t> row(pointsOfRing.size());
    for (std::uint32_t r = 0; r < row.size(); ++r) {
      row[r] = upwards ? static_cast<std::uint32_t>(row.size()) - 1 - r : r;
    }
    std::vector<std::uint32_t> places;  // rows for the rings that have points, from top to bottom
    places.reserve(filled.size());
    for (const std::uint32_t r : filled) places.push_back(row[r]);
    std::ranges::sort(places);
    for (std::size_t i = 0; i < sorted.size(); ++i) row[sorted[i]] = places[i];
    return row;
  }

  void byBeams() {
    const PointKey extent = extentOf(scan_);
    const std::uint32_t rings = std::max(scan_.rings, extent.ring);
    const std::uint32_t columns = std::max(scan_.columns, extent.column);
    std::vector<std::vector<std::uint32_t>> ofRing(rings);
    for (const std::uint32_t i : points_) ofRing[keyOf(scan_, i).ring].push_back(i);
    // Find the azimuth step per column from points in neighbouring columns of a ring.
    std::vector<double> steps;
    for (const auto& points : ofRing) {
      for (std::size_t k = 1; k < points.size(); ++k) {
        const int further =
            static_cast<int>(keyOf(scan_, points[k]).column) - static_cast<int>(keyOf(scan_, points[k - 1]).column);
        if (further != 1) continue;
        steps.push_back(
            std::remainder(azimuthOf(scan_.position[points[k]]) - azimuthOf(scan_.position[points[k - 1]]), kTurn));
      }
    }
    const double step = steps.empty() ? 0 : medianOf(steps);
    start(rings, columns);
    grid_.knowsRings = grid_.knowsMisses = true;
    grid_.wraps = std::fabs(std::fabs(step) * columns - kTurn) < 2 * std::fabs(step);
    const std::vector<std::uint32_t> row = rowsOfRings(ofRing);
    std::vector<double> offset(rings, 0);  // azimuth of column 0 in each ring (rad)
    double first = 0;
    bool known = false;
    for (std::uint32_t r = 0; r < rings; ++r) {
      if (ofRing[r].empty()) continue;
      const auto own = [&](std::uint32_t i) { return azimuthOf(scan_.position[i]) - step * keyOf(scan_, i).column; };
      const double about = own(ofRing[r][ofRing[r].size() / 2]);
      std::vector<double> around;
      for (const std::uint32_t i : ofRing[r]) around.push_back(std::remainder(own(i) - about, kTurn));
      offset[r] = about + medianOf(around);
      if (!known) first = offset[r];
      known = true;
    }
    for (std::uint32_t r = 0; r < rings; ++r) {
      const double shift = step == 0 ? 0 : std::round(std::remainder(offset[r] - first, kTurn) / step);
      for (const std::uint32_t i : ofRing[r]) {
        const auto column = static_cast<std::int64_t>(keyOf(scan_, i).column) + static_cast<std::int64_t>(shift);
        const std::int64_t n = columns;
        if (!grid_.wraps && (column < 0 || column >= n)) continue;
        put(row[r], static_cast<std::uint32_t>(((column % n) + n) % n), i);
      }
    }
  }

  void byRings() {
    constexpr double kLeastStep = kTurn / 8192;
    const std::vector<std::uint16_t>& ring = scan_[kRing];
    const std::uint32_t rings = std::max<std::uint32_t>(scan_.rings, *std::ranges::max_element(ring) + 1u);
    std::vector<std::vector<std::uint32_t>> ofRing(rings);
    for (const std::uint32_t i : points_) ofRing[ring[i]].push_back(i);
    std::vector<double> steps;
    for (auto& points : ofRing) {
      std::ranges::stable_sort(points, [&](std::uint32_t a, std::uint32_t b) {
        return azimuthOf(scan_.position[a]) < azimuthOf(scan_.position[b]);
      });
      for (std::size_t k = 1; k < points.size(); ++k) {
        const double step = azimuthOf(scan_.position[points[k]]) - azimuthOf(scan_.position[points[k - 1]]);
        if (step >= kLeastStep) steps.push_back(step);
      }
    }
    const double about = steps.empty() ? kTurn / 1024 : medianOf(steps);
    const auto columns = static_cast<std::uint32_t>(std::max(1.0, std::round(kTurn / about)));
    const double step = kTurn / columns;
    // Find the offset of the azimuth steps: the circular mean of the azimuths modulo the step.
    double sine = 0, cosine = 0;
    for (const std::uint32_t i : points_) {
      sine += std::sin(azimuthOf(scan_.position[i]) * columns);
      cosine += std::cos(azimuthOf(scan_.position[i]) * columns);
    }
    const double phase = std::atan2(sine, cosine) / columns;
    start(rings, columns);
    grid_.knowsRings = grid_.knowsMisses = grid_.wraps = true;
    const std::vector<std::uint32_t> row = rowsOfRings(ofRing);
    for (std::uint32_t r = 0; r < rings; ++r) {
      // Azimuths are noisy, so a rounded column may be wrong by one. A point that is less than 1.5 steps after the
      // previous point gets the column after the previous point's column.
      std::int64_t last = -2;  // column of the previous point; -2: there is no previous point
      double before = 0;
      for (const std::uint32_t i : ofRing[r]) {
        const double azimuth = azimuthOf(scan_.position[i]) + kPi - phase;
        auto column = static_cast<std::int64_t>(std::round(azimuth / step));
        if (last > -2) {
          if (azimuth - before < kLeastStep) {
            column = last;  // another return of the same beam
          } else if (column == last + 2 && azimuth - before < 1.5 * step) {
            column = last + 1;
          } else {
            column = std::max(column, last + 1);
          }
        }
        last = column;
        before = azimuth;
        put(row[r], static_cast<std::uint32_t>((column + columns) % columns), i);
      }
    }
  }

  void byAngles() {
    constexpr std::uint32_t kRows = 64, kColumns = 1024;
    constexpr double kBeyond = 0.005;  // fraction of the points that is left out at the top and at the bottom
    std::vector<double> elevations;
    for (const std::uint32_t i : points_) elevations.push_back(elevationOf(scan_.position[i]));
    std::vector<double> sorted = elevations;
    std::ranges::sort(sorted);
    const auto cut = static_cast<std::size_t>(kBeyond * static_cast<double>(sorted.size()));
    const double low = sorted[cut];
    const double high = sorted[sorted.size() - 1 - cut];
    start(kRows, kColumns);
    grid_.wraps = true;
    for (std::size_t k = 0; k < points_.size(); ++k) {
      if (elevations[k] < low || elevations[k] > high) continue;
      const double down = high > low ? (high - elevations[k]) / (high - low) : 0;
      const auto row = static_cast<std::uint32_t>(std::min<double>(kRows - 1, down * kRows));
      const double round = (azimuthOf(scan_.position[points_[k]]) + kPi) / kTurn;
      put(row, static_cast<std::uint32_t>(std::min<double>(kColumns - 1, round * kColumns)), points_[k]);
    }
  }

  const Scan& scan_;
  std::vector<std::uint32_t> points_;  // indices of finite points
  RangeGrid grid_;
};

}  // namespace

std::uint32_t RangeGrid::beside(std::uint32_t row, std::uint32_t column, int steps) const {
  std::int64_t to = std::int64_t{column} + steps;
  if (to < 0 || to >= std::int64_t{columns}) {
    if (!wraps) return kNone;
    to = ((to % columns) + columns) % columns;
  }
  return static_cast<std::uint32_t>(at(row, static_cast<std::uint32_t>(to)));
}

RangeGrid rangeGrid(const Scan& scan) {
  return GridMaker(scan).make();
}

}  // namespace scanmill
