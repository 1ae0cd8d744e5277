#include "exports/semantic_kitti_voxels.h"

#include <algorithm>
#include <cmath>

#include "formats/little_endian.h"

namespace scanmill {
namespace {

// Returns the flags as bits, see VoxelFiles.
std::string packed(const std::vector<std::uint8_t>& flags) {
  std::string bytes((flags.size() + 7) / 8, '\0');
  for (std::size_t i = 0; i < flags.size(); ++i) {
    if (flags[i] != 0) bytes[i / 8] = static_cast<char>(static_cast<unsigned char>(bytes[i / 8]) | 0x80u >> i % 8);
  }
  return bytes;
}

}  // namespace

std::vector<std::uint8_t> occludedVoxels(const ScanVoxels& voxels) {
  const VoxelGrid& grid = voxels.grid;
  const Vec3d sensor = grid.inVoxels({});
  const auto isInside = [](double coordinate, std::uint32_t count) { return coordinate >= 0 && coordinate < count; };
  // `center`: of the voxel. Positions are in voxels; a step is one voxel along the axis on which the sensor is
  // farthest.
  const auto isOccluded = [&](const Vec3d& center) {
    const Vec3d toSensor = sensor - center;
    const double steps = std::max({std::fabs(toSensor.x), std::fabs(toSensor.y), std::fabs(toSensor.z)});
    const Vec3d step = toSensor * (1 / steps);
    Vec3d position = center;
    const int stepsBefore = static_cast<int>(std::ceil(steps)) - 1;  // excludes the sensor's voxel
    for (int i = 0; i < stepsBefore; ++i) {
      position += step;
      // The grid is convex, so a line that leaves it does not enter it again.
      if (!isInside(position.x, grid.counts[0]) || !isInside(position.y, grid.counts[1]) ||
          !isInside(position.z, grid.counts[2]))
        return false;
      const std::size_t voxel =
          grid.index(static_cast<std::uint32_t>(position.x), static_cast<std::uint32_t>(position.y),
                     static_cast<std::uint32_t>(position.z));
      if (voxels.label[voxel] != 0 || voxels.input[voxel] != 0) return true;
    }
    return false;
  };
  std::vector<std::uint8_t> occluded(grid.voxels(), 0);
  for (std::uint32_t x = 0; x < grid.counts[0]; ++x) {
    for (std::uint32_t y = 0; y < grid.counts[1]; ++y) {
      for (std::uint32_t z = 0; z < grid.counts[2]; ++z) {
        occluded[grid.index(x, y, z)] = isOccluded({x + 0.5, y + 0.5, z + 0.5}) ? 1 : 0;
      }
    }
  }
  return occluded;
}

VoxelFiles semanticKittiVoxels(const ScanVoxels& voxels, const ClassMap& classes) {
  VoxelFiles files;
  files.bin = packed(voxels.input);
  for (const std::uint16_t label : voxels.label) putNumber(label == 0 ? label : classes.targetId(label), files.label);
  files.invalid = packed(voxels.invalid);
  files.occluded = packed(occludedVoxels(voxels));
  return files;
}

}  // namespace scanmill
