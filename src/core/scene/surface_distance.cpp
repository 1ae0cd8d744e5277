#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "scene/surface_heights.h"
#include "scene/triangles.h"

namespace scanmill {
namespace {

constexpr double kMostCellsAlong = 512;  // along the longer side of the grid
constexpr double kLeastCell = 1e-6;      // m, edge of a cell
constexpr std::size_t kMostTriangles = 10'000'000;

// Returns the horizontal distance of a point from the line segment between a and b.
double distanceToSegment(const Vec3d& point, const Vec3d& a, const Vec3d& b) {
  const double edgeX = b.x - a.x;
  const double edgeY = b.y - a.y;
  const double squaredLength = edgeX * edgeX + edgeY * edgeY;
  const double fraction =
      squaredLength > 0 ? std::clamp(((point.x - a.x) * edgeX + (point.y - a.y) * edgeY) / squaredLength, 0.0, 1.0) : 0;
  return std::hypot(point.x - a.x - fraction * edgeX, point.y - a.y - fraction * edgeY);
}

// Returns the horizontal distance of `p` from a triangle; 0 above or below it. Seen from above, a vertical triangle is
// a line.
double distanceToTriangle(const std::array<Vec3d, 3>& corners, const Vec3d& p) {
  int leftEdges = 0;  // edges that have the point to their left
  int rightEdges = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d& a = corners[k];
    const Vec3d& b = corners[(k + 1) % 3];
    const double cross = (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
    leftEdges += cross > 0 ? 1 : 0;
    rightEdges += cross < 0 ? 1 : 0;
    nearest = std::min(nearest, distanceToSegment(p, a, b));
  }
  return leftEdges == 3 || rightEdges == 3 ? 0 : nearest;
}

}  // namespace

SurfaceDistance::SurfaceDistance(const Scene& scene, const std::vector<std::uint16_t>& classes, double reach)
    : reach_(reach) {
  Box bounds;
  forEachTriangleOf(scene, classes, scene.instances.size(),
                    [&](std::uint32_t, std::uint32_t, const std::array<Vec3d, 3>& corners) {
                      if (triangles_.size() == kMostTriangles) {
                        throw InputError(
                            "distance_from: more than ten million triangles of these classes are placed: "
                            "name a class of which there is less");
                      }
                      triangles_.push_back(corners);
                      for (const Vec3d& corner : corners) bounds.add(corner);
                    });
  if (triangles_.empty()) return;
  low_ = bounds.low;
  const Vec3d size = bounds.high - bounds.low;
  edge_ = std::max({reach, size.x / kMostCellsAlong, size.y / kMostCellsAlong, kLeastCell});
  columns_ = static_cast<std::size_t>(size.x / edge_) + 1;
  rows_ = static_cast<std::size_t>(size.y / edge_) + 1;
  cells_.resize(columns_ * rows_);
  for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
    Box box;
    for (const Vec3d& corner : triangles_[i]) box.add(corner);
    const auto [firstX, firstY] = cellOf(box.low.x, box.low.y);
    const auto [lastX, lastY] = cellOf(box.high.x, box.high.y);
    for (std::size_t x = firstX; x <= lastX; ++x) {
      for (std::size_t y = firstY; y <= lastY; ++y) cells_[x * rows_ + y].push_back(i);
    }
  }
}

std::array<std::size_t, 2> SurfaceDistance::cellOf(double x, double y) const {
  const auto index = [&](double offset, std::size_t count) {
    return static_cast<std::size_t>(std::clamp(offset / edge_, 0.0, static_cast<double>(count - 1)));
  };
  return {index(x - low_.x, columns_), index(y - low_.y, rows_)};
}

double SurfaceDistance::at(double x, double y) const {
  constexpr double kBeyondReach = std::numeric_limits<double>::infinity();
  if (triangles_.empty()) return kBeyondReach;
  // Search all cells that overlap the square about the point with sides of 2 * reach_.
  const auto [firstX, firstY] = cellOf(x - reach_, y - reach_);
  const auto [lastX, lastY] = cellOf(x + reach_, y + reach_);
  double nearest = kBeyondReach;
  for (std::size_t column = firstX; column <= lastX; ++column) {
    for (std::size_t row = firstY; row <= lastY; ++row) {
      for (const std::uint32_t t : cells_[column * rows_ + row]) {
        nearest = std::min(nearest, distanceToTriangle(triangles_[t], {x, y, 0}));
      }
    }
  }
  return nearest <= reach_ ? nearest : kBeyondReach;
}

}  // namespace scanmill
