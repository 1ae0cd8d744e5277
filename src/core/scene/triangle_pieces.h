#pragma once

// Cuts triangles along the faces of voxels.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "base/vec.h"

namespace scanmill {

// A range of voxels: indices from `low` to `high` - 1 along x, y and z.
struct VoxelRange {
  std::array<std::int64_t, 3> low{};
  std::array<std::int64_t, 3> high{};
};

// A convex polygon in a plane.
class TrianglePiece {
 public:
  // Creates a polygon without corners.
  TrianglePiece() {}  // leaves corners_ uninitialised for speed
  explicit TrianglePiece(const std::array<Vec3d, 3>& corners) {
    for (const Vec3d& corner : corners) add({corner.x, corner.y, corner.z});
  }

  bool empty() const { return count_ == 0; }

  // Returns the smallest and the largest coordinate along an axis.
  std::array<double, 2> extent(std::size_t axis) const {
    double least = INFINITY, greatest = -INFINITY;
    for (std::size_t i = 0; i < count_; ++i) {
      least = std::min(least, corners_[i][axis]);
      greatest = std::max(greatest, corners_[i][axis]);
    }
    return {least, greatest};
  }

  double area() const {
    const auto fromFirst = [&](std::size_t i) {
      return Vec3d{corners_[i][0] - corners_[0][0], corners_[i][1] - corners_[0][1], corners_[i][2] - corners_[0][2]};
    };
    Vec3d sum;
    for (std::size_t i = 2; i < count_; ++i) sum += cross(fromFirst(i - 1), fromFirst(i));
    return length(sum) / 2;
  }

  // Splits the polygon at a plane perpendicular to an axis into the parts below and above the plane (Sutherland and
  // Hodgman, "Reentrant polygon clipping", Communications of the ACM 17 (1974)). Points in the plane are not below it.
  void split(std::size_t axis, double plane, TrianglePiece& below, TrianglePiece& above) const {
    below.count_ = above.count_ = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const Corner& start = corners_[i];
      const Corner& end = corners_[i + 1 < count_ ? i + 1 : 0];
      const bool startsBelow = start[axis] < plane;
      (startsBelow ? below : above).add(start);
      if (startsBelow == (end[axis] < plane)) continue;
      const double fraction = (plane - start[axis]) / (end[axis] - start[axis]);
      Corner cut;
      for (std::size_t k = 0; k < 3; ++k) cut[k] = start[k] + (end[k] - start[k]) * fraction;
      cut[axis] = plane;
      below.add(cut);
      above.add(cut);
    }
  }

 private:
  using Corner = std::array<double, 3>;

  // A triangle that six planes have cut has at most nine corners. Rounding can make an extremely thin piece concave,
  // and cuts can then add more corners. Corners beyond kMostCorners are dropped, which changes only a negligible area.
  static constexpr std::size_t kMostCorners = 12;

  void add(const Corner& corner) {
    if (count_ < kMostCorners) corners_[count_++] = corner;
  }

  std::array<Corner, kMostCorners> corners_;
  std::size_t count_ = 0;
};

// Cuts a piece along `Axis` and the axes after it, and calls visit(voxel, area) for each voxel of the range in which
// the piece has some area. Along the axes before `Axis` the piece is within a single voxel, whose index is in `voxel`.
template <std::size_t Axis, class Visit>
void cutPiece(const TrianglePiece& piece, const VoxelRange& range, std::array<std::int64_t, 3>& voxel,
              const Visit& visit) {
  if constexpr (Axis == 3) {
    const double area = piece.area();
    if (area > 0) visit(voxel, area);
  } else {
    const auto [least, greatest] = piece.extent(Axis);
    const auto low = static_cast<double>(range.low[Axis]);
    const auto high = static_cast<double>(range.high[Axis]);
    if (!(greatest >= low) || !(least < high)) return;
    const auto first = static_cast<std::int64_t>(std::floor(std::max(least, low)));
    const auto last = static_cast<std::int64_t>(std::floor(std::min(greatest, high)));
    voxel[Axis] = first;
    if (first == last && least >= low) return cutPiece<Axis + 1>(piece, range, voxel, visit);
    TrianglePiece remaining = piece;
    TrianglePiece below;
    TrianglePiece above;
    if (least < low) {
      piece.split(Axis, low, below, above);
      remaining = above;
    }
    for (std::int64_t index = first; index < range.high[Axis] && !remaining.empty(); ++index) {
      voxel[Axis] = index;
      if (index == last) return cutPiece<Axis + 1>(remaining, range, voxel, visit);
      remaining.split(Axis, static_cast<double>(index + 1), below, above);
      if (!below.empty()) cutPiece<Axis + 1>(below, range, voxel, visit);
      std::swap(remaining, above);
    }
  }
}

// Calls visit(voxel, area) for each voxel of a range in which a triangle has some area, in the order of the voxels'
// indices. `area`: the triangle's area in the voxel. A voxel that the triangle only touches is not visited.
// The unit of length is a voxel's edge: voxel i of an axis is [i, i + 1).
template <class Visit>
void forEachPiece(const std::array<Vec3d, 3>& corners, const VoxelRange& range, const Visit& visit) {
  std::array<std::int64_t, 3> voxel{};
  cutPiece<0>(TrianglePiece(corners), range, voxel, visit);
}

}  // namespace scanmill
