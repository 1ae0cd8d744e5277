#pragma once

// Finds which voxels around a sensor contain points of its scan, and which of them the sensor sees.

#include <cstdint>

#include "dataset/voxels.h"
#include "scan/hits.h"
#include "scan/scan.h"
#include "scene/voxels.h"
#include "sensors/shot.h"

namespace scanmill {

// Returns the voxels of a scan. `labels`: the labels of the grid, whose frame is the sensor's frame at the start of the
// revolution. `hits`: the hits from which the scan was made. `raysPerBeam`: number of rays per beam; the first ray of
// each beam is its axis.
//
// - `input` is set for voxels that contain points of the scan, after all effects. The points of a moving sensor are
//   transformed from the sensor's frame at the time of their column to the grid's frame; if the scan is dense, it needs
//   the column `column` for this. Deskewed points are in the grid's frame already.
// - `unseen` is set for voxels that no beam's axis passes through or ends in, empty or not. The axis goes from the
//   sensor, at the time when the beam fires, to the first hit; if the beam has a single ray, it continues through clear
//   glass. If there is no hit, the axis goes to the sensor's maximum range, even if a surface nearer than the minimum
//   range may block the beam. Beams that are unresolved, or without a hit because of the ego vehicle, are ignored.
// - `invalid` is set for unseen voxels that no sensor could see, and for voxels whose surfaces have no class. An empty
//   voxel is called open if a chain of empty voxels that share faces connects it to a voxel that a beam passes through.
//   Unseen empty voxels are invalid if they are not open: they are under ground or inside of closed solids. Unseen
//   voxels with surfaces are invalid if none of the voxels that share a face with them is open: they are inside of
//   objects. Voxels with surfaces without a class are invalid since their label would say that they are empty.
ScanVoxels viewVoxels(const VoxelGrid& grid, VoxelLabels labels, const Shot& shot, std::uint32_t raysPerBeam,
                      const Hits& hits, const Scan& scan);

}  // namespace scanmill
