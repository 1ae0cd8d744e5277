#pragma once

// Voxels as SemanticKITTI's task of scene completion has them, and its API reads them.

#include <cstdint>
#include <string>
#include <vector>

#include "dataset/voxels.h"
#include "exports/class_map.h"

namespace scanmill {

// Of a scan, in the folder voxels of its sequence. Voxels are in the order of VoxelGrid::index(); flags are bits, eight
// of them a byte, the first in the highest bit.
struct VoxelFiles {
  std::string bin;       // flags: a point of the scan lies in it
  std::string label;     // uint16: the class, 0 empty
  std::string invalid;   // flags: nothing can be known of it
  std::string occluded;  // flags, see occludedVoxels()
};

VoxelFiles semanticKittiVoxels(const ScanVoxels& voxels, const ClassMap& classes);

// Of each voxel, whether another that holds something stands between it and the sensor, which is the origin: 1, else 0.
// The line of sight from its middle meets one voxel in each layer along the line's longest axis.
std::vector<std::uint8_t> occludedVoxels(const ScanVoxels& voxels);

}  // namespace scanmill
