#pragma once

// Files of bare float32 records, as KITTI, SemanticKITTI and nuScenes store their scans, and the labels beside them.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "scan/scan.h"

namespace scanmill {

// How many numbers a record of such a file has, by its name: 4 of .bin (x, y, z, intensity: KITTI), 5 of .pcd.bin (and
// the ring: nuScenes); 0 of others.
std::size_t numbersOfRecord(const std::filesystem::path& file);

// Reads records of 4 or 5 numbers. KITTI's files hold ring after ring, from the top, each going round once from
// straight ahead: there the column `ring` is counted from the order of the points, and is left out where the order is
// another. Throws an InputError that begins with `what` where the bytes are no whole records, a coordinate is not
// finite or beyond 100 km, or a ring is no whole number from 0 to 65535.
Scan readPointRecords(std::string_view bytes, std::size_t numbers, const std::string& what);

// Adds `label` and `instance` of SemanticKITTI's .label files, a uint32 a point: class in the lower 16 bits, instance
// in the upper. Throws an InputError that begins with `what` where there are not as many as points.
void addSemanticKittiLabels(std::string_view bytes, const std::string& what, Scan& scan);

// Adds `label` of nuScenes' lidarseg files, a uint8 a point. Throws likewise.
void addLidarsegLabels(std::string_view bytes, const std::string& what, Scan& scan);

// The file of SemanticKITTI's labels of a scan: labels/000000.label beside velodyne/000000.bin; empty where there is
// none.
std::filesystem::path labelsBeside(const std::filesystem::path& scan);

}  // namespace scanmill
