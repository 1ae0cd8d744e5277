#include "sensors/beam_grid.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace scanmill {

namespace {

double elevationOf(const Vec3d& d) {
  return std::atan2(d.z, std::hypot(d.x, d.y));
}

double angleBetween(const Vec3d& a, const Vec3d& b) {
  return std::atan2(length(cross(a, b)), dot(a, b));
}

}  // namespace

std::uint32_t BeamGrid::rowOf(double elevation) {
  return static_cast<std::uint32_t>(std::clamp((elevation / kPi + 0.5) * kUp, 0.0, kUp - 1.0));
}

std::uint32_t BeamGrid::columnOf(double azimuth) {
  const double turns = azimuth / (2 * kPi);
  return static_cast<std::uint32_t>((turns - std::floor(turns)) * kAcross) % kAcross;
}

BeamGrid::BeamGrid(const BeamTable& beams) : directions_(beams.direction), firstOf_(kAcross * kUp + 1) {
  std::vector<std::uint32_t> cells;
  cells.reserve(directions_.size());
  for (const Vec3d& d : directions_) {
    cells.push_back(rowOf(elevationOf(d)) * kAcross + columnOf(std::atan2(d.y, d.x)));
    ++firstOf_[cells.back() + 1];
  }
  // The sums of the counts are the positions at which the cells begin in beams_.
  std::partial_sum(firstOf_.begin(), firstOf_.end(), firstOf_.begin());
  beams_.resize(cells.size());
  std::vector<std::uint32_t> nextOf(firstOf_.begin(), firstOf_.end() - 1);  // by cell: index for its next beam
  for (std::uint32_t b = 0; b < cells.size(); ++b) beams_[nextOf[cells[b]]++] = b;

  for (const Vec3f& origin : beams.origin) farthestOrigin_ = std::max(farthestOrigin_, double{length(origin)});

  // Take a percentile of the angles between neighbouring beams instead of the largest: some patterns have a few wide
  // gaps. Every 16th column is enough to estimate the percentile.
  std::vector<double> angles;  // rad
  for (std::uint32_t ring = 0; ring < beams.rings; ++ring) {
    for (std::uint32_t column = 0; column < beams.columns; column += 16) {
      const std::size_t beam = std::size_t{ring} * beams.columns + column;
      const Vec3d& direction = directions_[beam];
      if (column + 1 < beams.columns) angles.push_back(angleBetween(direction, directions_[beam + 1]));
      if (ring + 1 < beams.rings) angles.push_back(angleBetween(direction, directions_[beam + beams.columns]));
    }
  }
  if (angles.empty()) return;
  const auto percentile = angles.begin() + static_cast<std::ptrdiff_t>(angles.size() * 99 / 100);
  std::nth_element(angles.begin(), percentile, angles.end());
  neighbourAngle_ = std::min(1.5 * *percentile, radians(10));
}

BeamGrid::CellRange BeamGrid::cellsAround(const Vec3d& direction, double angle) {
  const double elevation = elevationOf(direction);
  CellRange cells{.firstRow = rowOf(elevation - angle), .lastRow = rowOf(elevation + angle)};
  // A cone that contains a pole covers all azimuths. Any other cone covers asin(sin(angle) / cos(elevation)) on each
  // side of its axis.
  const double sine = std::sin(angle) / std::cos(elevation);
  if (std::abs(elevation) + angle >= kPi / 2 || !(sine < 1)) {
    cells.columns = kAcross;
    return cells;
  }
  const double halfWidth = std::asin(sine);  // rad of azimuth
  cells.firstColumn = columnOf(std::atan2(direction.y, direction.x) - halfWidth);
  cells.columns = std::min<std::uint32_t>(kAcross, static_cast<std::uint32_t>(2 * halfWidth / (2 * kPi) * kAcross) + 2);
  return cells;
}

bool BeamGrid::looksInto(const Vec3d& direction, std::uint32_t& near) const {
  const double leastCosine = std::cos(neighbourAngle_);
  const auto isNear = [&](std::uint32_t beam) {
    if (dot(directions_[beam], direction) < leastCosine) return false;
    near = beam;
    return true;
  };
  return isNear(near) || forBeamsNear(direction, neighbourAngle_, isNear);
}

}  // namespace scanmill
