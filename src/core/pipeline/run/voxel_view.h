#pragma once

// What a scan has of the voxels about its sensor.

#include <cstdint>

#include "dataset/voxels.h"
#include "scan/hits.h"
#include "scan/scan.h"
#include "scene/voxels.h"
#include "sensors/shot.h"

namespace scanmill {

// `labels`: those of the grid, whose frame is the sensor's at the start of the revolution. The hits are those that the
// scan was made of. `raysPerBeam`: that were fired, each beam's axis first.
//
// - `input` are the voxels of the points, with all that effects do to them. Those of a sensor that moves are taken from
//   the frames of their columns to the grid's, unless the shot is deskewed and they are there already; a dense scan
//   needs the column `column` for that.
// - A scan sees the voxels that the axes of its beams pass through or end in, each from where and when it is fired to
//   what it meets first; one of a single ray behind clear glass as far as it goes on. A beam without a hit goes as far
//   as the sensor's range: what is too near for the sensor is not known to block it, unless it is the own vehicle. All
//   else is `unseen`, whether or not anything stands there.
// - `invalid` is of the empty voxels each that is not seen and that no way leads to, from one empty voxel to the next
//   across their faces within the grid, from any that a beam passes through: what is under ground, and the inside of
//   closed solids. Of the others it is each that is not seen and has no such voxel at any of its faces, within the
//   matter of things; and each that holds surfaces of no class, whose label would say that it is empty.
ScanVoxels viewVoxels(const VoxelGrid& grid, VoxelLabels labels, const Shot& shot, std::uint32_t raysPerBeam,
                      const Hits& hits, const Scan& scan);

}  // namespace scanmill
