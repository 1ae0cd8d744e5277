#pragma once

// A grid of cubes, which finds the voxel of a point. This header is installed because pipeline/read/pipeline.h includes
// it.
//
//   const VoxelGrid grid;
//   const std::optional<std::size_t> voxel = grid.at({10, 0, -1.5});  // the point is in the grid's frame (m)

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "base/vec.h"

namespace scanmill {

// A grid along the axes of a frame, usually a sensor's. The default is SemanticKITTI's grid for scene completion. The
// index of a voxel is (x * counts[1] + y) * counts[2] + z: x varies slowest and z fastest, as in SemanticKITTI's files.
struct VoxelGrid {
  double size = 0.2;                                  // m, edge of a voxel
  Vec3d low{0, -25.6, -2};                            // m, the corner with the smallest coordinates
  std::array<std::uint32_t, 3> counts{256, 256, 32};  // number of voxels along x, y and z; their product is below 2^32

  std::size_t voxels() const { return std::size_t{counts[0]} * counts[1] * counts[2]; }
  std::size_t index(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return (std::size_t{x} * counts[1] + y) * counts[2] + z;
  }

  // Returns a point (m) in units of voxels from the low corner: voxel i of an axis is [i, i + 1). A point on the face
  // between two voxels is thus in the upper voxel. Floors and walls are often at round coordinates, exactly between two
  // voxels, where rounding would scatter them over both layers. Therefore the grid is shifted down along each axis by
  // kLower times the edge of a voxel (0.1 mm for voxels of 0.2 m).
  static constexpr double kLower = 1.0 / 2048;
  Vec3d inVoxels(const Vec3d& position) const {
    const Vec3d p = (position - low) * (1 / size);
    return {p.x + kLower, p.y + kLower, p.z + kLower};
  }

  // Returns the index of the voxel that contains a point (m); nullopt outside of the grid or if the point is not
  // finite.
  std::optional<std::size_t> at(const Vec3d& position) const {
    const Vec3d p = inVoxels(position);
    const auto inside = [](double coordinate, std::uint32_t count) { return coordinate >= 0 && coordinate < count; };
    if (!inside(p.x, counts[0]) || !inside(p.y, counts[1]) || !inside(p.z, counts[2])) return std::nullopt;
    return index(static_cast<std::uint32_t>(p.x), static_cast<std::uint32_t>(p.y), static_cast<std::uint32_t>(p.z));
  }

  bool operator==(const VoxelGrid&) const = default;
};

}  // namespace scanmill
