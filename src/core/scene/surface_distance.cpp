#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "scene/surface_heights.h"
#include "scene/triangles.h"

namespace scanmill {
namespace {

constexpr double kMostCells = 512;  // a cell is at least 1/512 as wide as the longer side of the grid
constexpr std::size_t kMostTriangles = 10'000'000;

double distanceToSegment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const double x = b.x - a.x;
  const double y = b.y - a.y;
  const double squared = x * x + y * y;
  const double along = squared > 0 ? std::clamp(((p.x - a.x) * x + (p.y - a.y) * y) / squared, 0.0, 1.0) : 0;
  return std::hypot(p.x - a.x - along * x, p.y - a.y - along * y);
}

// Returns the horizontal distance of `p` from a triangle; 0 above or below it. Seen from above, a vertical triangle is
// a line.
double distanceTo(const std::array<Vec3d, 3>& c, const Vec3d& p) {
  int left = 0;
  int right = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d& a = c[k];
    const Vec3d& b = c[(k + 1) % 3];
    const double side = (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
    left += side > 0 ? 1 : 0;
    right += side < 0 ? 1 : 0;
    nearest = std::min(nearest, distanceToSegment(p, a, b));
  }
  return left == 3 || right == 3 ? 0 : nearest;
}

}  // namespace

SurfaceDistance::SurfaceDistance(const Scene& scene, const std::vector<std::uint16_t>& classes, double reach)
    : reach_(reach) {
  Box all;
  forEachTriangleOf(scene, classes, scene.instances.size(),
                    [&](std::uint32_t, std::uint32_t, const std::array<Vec3d, 3>& corners) {
                      if (triangles_.size() == kMostTriangles) {
                        throw InputError(
                            "distance_from: more than ten million triangles of these classes are placed: "
                            "name a class of which there is less");
                      }
                      triangles_.push_back(corners);
                      for (const Vec3d& corner : corners) all.add(corner);
                    });
  if (triangles_.empty()) return;
  low_ = all.low;
  const Vec3d size = all.high - all.low;
  side_ = std::max({reach, size.x / kMostCells, size.y / kMostCells, 1e-6});
  across_ = static_cast<std::size_t>(size.x / side_) + 1;
  along_ = static_cast<std::size_t>(size.y / side_) + 1;
  cells_.resize(across_ * along_);
  for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
    Box box;
    for (const Vec3d& corner : triangles_[i]) box.add(corner);
    const auto [fromX, fromY] = cellOf(box.low.x, box.low.y);
    const auto [toX, toY] = cellOf(box.high.x, box.high.y);
    for (std::size_t x = fromX; x <= toX; ++x) {
      for (std::size_t y = fromY; y <= toY; ++y) cells_[x * along_ + y].push_back(i);
    }
  }
}

std::array<std::size_t, 2> SurfaceDistance::cellOf(double x, double y) const {
  const auto number = [&](double d, std::size_t count) {
    return static_cast<std::size_t>(std::clamp(d / side_, 0.0, static_cast<double>(count - 1)));
  };
  return {number(x - low_.x, across_), number(y - low_.y, along_)};
}

double SurfaceDistance::at(double x, double y) const {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  if (triangles_.empty()) return kNone;
  // Search all cells that overlap the square about the point with sides of 2 * reach_.
  const auto [fromX, fromY] = cellOf(x - reach_, y - reach_);
  const auto [toX, toY] = cellOf(x + reach_, y + reach_);
  double nearest = kNone;
  for (std::size_t i = fromX; i <= toX; ++i) {
    for (std::size_t j = fromY; j <= toY; ++j) {
      for (const std::uint32_t t : cells_[i * along_ + j]) {
        nearest = std::min(nearest, distanceTo(triangles_[t], {x, y, 0}));
      }
    }
  }
  return nearest <= reach_ ? nearest : kNone;
}

}  // namespace scanmill
