#pragma once

// The member `<key>.<sensor>.<method>.voxels.npz` of a sample: the classes of the voxels around a sensor, and which
// voxels its scan sees, as in SemanticKITTI's scene completion task (Behley et al., "SemanticKITTI: A Dataset for
// Semantic Scene Understanding of LiDAR Sequences", ICCV 2019, section 4.3). numpy.load() reads the archive without
// pickle:
//
//   label     uint16 (X, Y, Z)   class of the voxel; 0: empty
//   input     bool (X, Y, Z)     the voxel contains a point of the scan
//   invalid   bool (X, Y, Z)     nothing can be known about the voxel
//   unseen    bool (X, Y, Z)     no beam of the scan passes through the voxel or ends in it
//   low       float64 (3,)       m, the corner of the grid where all coordinates are least, in the frame of the points
//   size      float64 ()         m, length of a voxel's edge

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scene/voxel_grid.h"

namespace scanmill {

// The suffix of a shard's members with voxels, used like the suffix of a format.
inline constexpr std::string_view kVoxelsSuffix = "voxels.npz";

// The voxels of one scan. Each vector has one entry per voxel of the grid, which is in the frame of the scan's points.
struct ScanVoxels {
  VoxelGrid grid;
  std::vector<std::uint16_t> label;   // id of the class with the largest area in the voxel; 0: empty, or no class
  std::vector<std::uint8_t> input;    // 1: the voxel contains at least one point of the scan
  std::vector<std::uint8_t> invalid;  // 1: the voxel must be ignored: its surfaces have no class, or it is neither seen
                                      // nor connected to seen voxels through empty voxels, as inside of objects
  std::vector<std::uint8_t> unseen;   // 1: no beam of the scan passes through the voxel or ends in it
};

// Returns the bytes of an archive with these voxels. Throws Error if a vector does not have one entry per voxel.
std::string encodeVoxels(const ScanVoxels& voxels);
// Reads the bytes of an archive. Throws an InputError that begins with `what` if the bytes are not an archive of
// voxels.
ScanVoxels decodeVoxels(std::string_view bytes, const std::string& what);
// Returns 1 for each voxel that is hidden from the sensor (at the origin) by another voxel that is not empty, otherwise
// 0. The line of sight from the voxel's centre visits one voxel per layer along the line's longest axis.
std::vector<std::uint8_t> occludedVoxels(const ScanVoxels& voxels);
// Returns an upper bound of the size of the result of encodeVoxels(). The result is usually a twentieth of the bound or
// less.
std::uint64_t mostVoxelsBytes(const VoxelGrid& grid);

}  // namespace scanmill
