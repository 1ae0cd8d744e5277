#pragma once

// The member `<key>.<sensor>.<method>.voxels.npz` of a sample: what stands in the voxels about a sensor, and what its
// scan has of them, as SemanticKITTI's task of scene completion has it (Behley et al., "SemanticKITTI: A Dataset for
// Semantic Scene Understanding of LiDAR Sequences", ICCV 2019, section 4.3). numpy.load() reads it without pickle:
//
//   label     uint16 (X, Y, Z)   class of the voxel; 0: empty
//   input     bool (X, Y, Z)     a point of the scan lies in it
//   invalid   bool (X, Y, Z)     nothing can be known of it
//   unseen    bool (X, Y, Z)     no beam of the scan passes through it or ends in it
//   low       float64 (3,)       m, the corner of the grid where all coordinates are least, in the frame of the points
//   size      float64 ()         m, of a voxel's edge

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scene/voxel_grid.h"

namespace scanmill {

// What stands in place of a format's suffix in the name of the member.
inline constexpr std::string_view kVoxelsSuffix = "voxels.npz";

// Of one scan; each vector has an entry per voxel of the grid, which is in the frame of the scan's points.
struct ScanVoxels {
  VoxelGrid grid;
  std::vector<std::uint16_t> label;   // class id of most of the surface in it; 0: it is empty, or of no class
  std::vector<std::uint8_t> input;    // 1: at least one point of the scan lies in it
  std::vector<std::uint8_t> invalid;  // 1: neither seen nor open to what is seen, such as the inside of things; or it
                                      // holds surfaces of no class
  std::vector<std::uint8_t> unseen;   // 1: no beam of the scan passes through it or ends in it
};

// Throws Error where a vector has not one entry per voxel.
std::string encodeVoxels(const ScanVoxels& voxels);
// Throws an InputError that begins with `what` for bytes that are no such archive.
ScanVoxels decodeVoxels(std::string_view bytes, const std::string& what);
// An upper bound of the bytes that encodeVoxels() makes. Most grids take a twentieth of it or less.
std::uint64_t mostVoxelsBytes(const VoxelGrid& grid);

}  // namespace scanmill
