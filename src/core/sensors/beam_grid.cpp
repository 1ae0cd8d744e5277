#include "sensors/beam_grid.h"

#include <algorithm>
#include <cmath>

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
  const double row = (elevation / kPi + 0.5) * kUp;
  return static_cast<std::uint32_t>(std::clamp(row, 0.0, kUp - 1.0));
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
  for (std::size_t c = 1; c < firstOf_.size(); ++c) firstOf_[c] += firstOf_[c - 1];
  beams_.resize(cells.size());
  std::vector<std::uint32_t> next(firstOf_.begin(), firstOf_.end() - 1);
  for (std::uint32_t b = 0; b < cells.size(); ++b) beams_[next[cells[b]]++] = b;

  for (const Vec3f& origin : beams.origin) farthestOrigin_ = std::max(farthestOrigin_, double{length(origin)});

  // Take a percentile of the angles between neighbouring beams instead of the largest: some patterns have a few wide
  // gaps.
  std::vector<double> gaps;
  for (std::uint32_t ring = 0; ring < beams.rings; ++ring) {
    for (std::uint32_t column = 0; column < beams.columns; column += 16) {
      const Vec3d& own = directions_[std::size_t{ring} * beams.columns + column];
      if (column + 1 < beams.columns) {
        gaps.push_back(angleBetween(own, directions_[std::size_t{ring} * beams.columns + column + 1]));
      }
      if (ring + 1 < beams.rings) {
        gaps.push_back(angleBetween(own, directions_[std::size_t{ring + 1} * beams.columns + column]));
      }
    }
  }
  if (gaps.empty()) return;
  const auto most = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() * 99 / 100);
  std::nth_element(gaps.begin(), most, gaps.end());
  reach_ = std::min(1.5 * *most, radians(10));
}

void BeamGrid::cellsOf(const Vec3d& direction, double angle, std::uint32_t& low, std::uint32_t& high,
                       std::uint32_t& first, std::uint32_t& count) {
  const double elevation = elevationOf(direction);
  low = rowOf(elevation - angle);
  high = rowOf(elevation + angle);
  // A cone that contains a pole covers all azimuths. Any other cone covers asin(sin(angle) / cos(elevation)) on each
  // side of its axis.
  const double wide = std::abs(elevation) + angle >= kPi / 2 ? 2.0 : std::sin(angle) / std::cos(elevation);
  if (!(wide < 1)) {
    first = 0;
    count = kAcross;
    return;
  }
  const double half = std::asin(wide);
  const double azimuth = std::atan2(direction.y, direction.x);
  first = columnOf(azimuth - half);
  count = std::min<std::uint32_t>(kAcross, static_cast<std::uint32_t>(2 * half / (2 * kPi) * kAcross) + 2);
}

bool BeamGrid::looksInto(const Vec3d& direction) const {
  const double least = std::cos(reach_);
  return forBeamsNear(direction, reach_,
                      [&](std::uint32_t beam) { return dot(directions_[beam], direction) >= least; });
}

}  // namespace scanmill
