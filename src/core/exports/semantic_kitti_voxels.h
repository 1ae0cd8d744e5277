#pragma once

// Voxels in the format of SemanticKITTI's scene completion task, which its API reads.

#include <cstdint>
#include <string>
#include <vector>

#include "dataset/voxels.h"
#include "exports/class_map.h"

namespace scanmill {

// The contents of a scan's files in the folder voxels of its sequence. Voxels are in the order of VoxelGrid::index().
// Flags are bits, eight per byte, the first in the highest bit.
struct VoxelFiles {
  std::string bin;       // flags: 1 if the voxel contains a point of the scan
  std::string label;     // uint16: class, 0 for an empty voxel
  std::string invalid;   // flags: 1 if the voxel must be ignored, see ScanVoxels
  std::string occluded;  // flags: 1 if another voxel hides the voxel, see occludedVoxels()
};

VoxelFiles semanticKittiVoxels(const ScanVoxels& voxels, const ClassMap& classes);

// Returns 1 for each voxel that is hidden from the sensor (at the origin) by another voxel that is not empty, otherwise
// 0. The line of sight from the voxel's centre visits one voxel per layer along the line's longest axis.
std::vector<std::uint8_t> occludedVoxels(const ScanVoxels& voxels);

}  // namespace scanmill
