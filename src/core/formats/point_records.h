#pragma once

// Reads files of bare float32 records, the scans of KITTI, SemanticKITTI and nuScenes, and the label files beside them.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "scan/scan.h"

namespace scanmill {

// Returns how many numbers each record of a file has, by the file's name: 4 for .bin (x, y, z, intensity: KITTI), 5 for
// .pcd.bin (with the ring: nuScenes); 0 for other names.
std::size_t numbersOfRecord(const std::filesystem::path& file);

// Reads records of 4 or 5 numbers. Records of 4 numbers have no ring. KITTI's files contain the rings in succession,
// from the top, each starting straight ahead; in such files the column `ring` is derived from the order of the points,
// in other files of 4 numbers the column stays empty. Points with a coordinate that is not finite are misses. Throws an
// InputError that begins with `what` if the bytes are not complete records, a coordinate is beyond 100 km, no point is
// finite, a ring is not a whole number from 0 to 65535, or many intensities are below 0.
Scan readPointRecords(std::string_view bytes, std::size_t numbers, const std::string& what);

// Adds the columns `label` and `instance` from a .label file of SemanticKITTI: one uint32 per point, class in the lower
// 16 bits, instance in the upper. Throws an InputError that begins with `what` if there are not as many labels as
// points.
void addSemanticKittiLabels(std::string_view bytes, const std::string& what, Scan& scan);

// Adds the column `label` from a lidarseg file of nuScenes, one uint8 per point. Throws like addSemanticKittiLabels().
void addLidarsegLabels(std::string_view bytes, const std::string& what, Scan& scan);

// Adds the column `instance`, and `label` if the scan has none, from a file of Panoptic nuScenes: a NumPy archive with
// the array `data` of one uint16 per point, 1000 * class + number of the instance. The instance is the complete number,
// since its last digits count within a class; 0 if these are 0. Throws like addSemanticKittiLabels().
void addPanopticLabels(std::string_view bytes, const std::string& what, Scan& scan);

// Returns the label file of a scan of SemanticKITTI: for velodyne/000000.bin the file labels/000000.label beside the
// folder velodyne; empty if there is none.
std::filesystem::path labelsBeside(const std::filesystem::path& scan);

}  // namespace scanmill
