#pragma once

// Finds which voxels around a sensor its scan has points in, and which it sees.

#include <cstdint>

#include "dataset/voxels.h"
#include "scan/hits.h"
#include "scan/scan.h"
#include "scene/voxels.h"
#include "sensors/shot.h"

namespace scanmill {

// Returns the voxels of a scan. `labels`: the labels of the grid, whose frame is the sensor's at the start of the
// revolution. `hits`: those from which the scan was made. `raysPerBeam`: rays of a beam, of which the first is the
// beam's axis.
//
// - `input` are the voxels with points in them, after all effects. Points of a moving sensor are transformed from the
//   frames of their columns to the grid's, unless the shot is deskewed and they are in the grid's frame already; a
//   dense scan needs the column `column` for the transform.
// - `unseen` are the voxels that no beam's axis passes through or ends in, whether or not they are empty. An axis runs
//   from the sensor, at the time when the beam fires, to the first hit; through clear glass it continues if the beam
//   has a single ray. Without a hit it runs to the sensor's maximum range, since a surface below the minimum range is
//   not known to block it; but a beam without a hit that the own vehicle blocks does not count.
// - `invalid` are voxels about which nothing can be known. An empty voxel is open if one that a beam passes through is
//   connected to it by empty voxels of the grid that share faces. Unseen empty voxels that are not open are invalid:
//   they are under ground or inside of closed solids. Unseen voxels with surfaces are invalid if no open voxel shares a
//   face with them: they are inside of objects. Voxels with surfaces of no class are invalid too, since their label
//   would say that they are empty.
ScanVoxels viewVoxels(const VoxelGrid& grid, VoxelLabels labels, const Shot& shot, std::uint32_t raysPerBeam,
                      const Hits& hits, const Scan& scan);

}  // namespace scanmill
