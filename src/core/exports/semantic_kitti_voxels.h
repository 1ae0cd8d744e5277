#pragma once

// Voxels in the format of SemanticKITTI's task of scene completion, which its API reads.

#include <cstdint>
#include <string>
#include <vector>

#include "dataset/voxels.h"
#include "exports/class_map.h"

namespace scanmill {

// The contents of the files of a scan in the folder voxels of its sequence. Voxels are in the order of
// VoxelGrid::index(). Flags are bits, eight per byte, the first in the highest bit.
struct VoxelFiles {
  std::string bin;       // flags: the voxel contains a point of the scan
  std::string label;     // uint16: the class, 0 empty
  std::string invalid;   // flags: nothing can be known about the voxel
  std::string occluded;  // flags, see occludedVoxels()
};

VoxelFiles semanticKittiVoxels(const ScanVoxels& voxels, const ClassMap& classes);

// Returns for each voxel 1 if a voxel that is not empty lies between it and the sensor, which is at the origin, else 0.
// The line of sight from the voxel's centre visits one voxel per layer along the line's longest axis.
std::vector<std::uint8_t> occludedVoxels(const ScanVoxels& voxels);

}  // namespace scanmill
