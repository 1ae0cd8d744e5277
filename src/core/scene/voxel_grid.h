#pragma once

// A grid of cubes: which voxel a place lies in.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "base/vec.h"

namespace scanmill {

// Along the axes of a frame, most often a sensor's. The default is SemanticKITTI's grid for scene completion. A voxel
// has an index, (x * counts[1] + y) * counts[2] + z: x is the slowest and z the fastest, as in SemanticKITTI's files.
struct VoxelGrid {
  double size = 0.2;                                  // m, of a voxel's edge
  Vec3d low{0, -25.6, -2};                            // m, the corner where all coordinates are least
  std::array<std::uint32_t, 3> counts{256, 256, 32};  // voxels along x, y and z; together fewer than 2^32

  std::size_t voxels() const { return std::size_t{counts[0]} * counts[1] * counts[2]; }
  std::size_t index(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    return (std::size_t{x} * counts[1] + y) * counts[2] + z;
  }

  // A place (m) counted in voxels from the low corner: voxel i of an axis holds what lies in [i, i + 1). Each place is
  // thus in one voxel, and what lies between two is in the upper one. Floors and walls stand at round coordinates, just
  // where voxels meet, and rounding would tear them to pieces in either layer; therefore the voxels lie this part of
  // their edge (0.1 mm of 0.2 m) lower than their grid says.
  static constexpr double kLower = 1.0 / 2048;
  Vec3d inVoxels(const Vec3d& place) const {
    const Vec3d p = (place - low) * (1 / size);
    return {p.x + kLower, p.y + kLower, p.z + kLower};
  }

  // The index of the voxel that a place (m) lies in; none outside of the grid and for what is not finite.
  std::optional<std::size_t> at(const Vec3d& place) const {
    const Vec3d p = inVoxels(place);
    const auto inside = [](double along, std::uint32_t count) { return along >= 0 && along < count; };
    if (!inside(p.x, counts[0]) || !inside(p.y, counts[1]) || !inside(p.z, counts[2])) return std::nullopt;
    return index(static_cast<std::uint32_t>(p.x), static_cast<std::uint32_t>(p.y), static_cast<std::uint32_t>(p.z));
  }

  bool operator==(const VoxelGrid&) const = default;
};

}  // namespace scanmill
