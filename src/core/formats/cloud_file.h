#pragma once

// Clouds of points as scanners, surveys and other programs leave them: .las, .ply, .pcd, the formats of datasets, and
// single scans of public datasets: .bin, .pcd.bin and .npz.

#include <filesystem>
#include <string>

#include "base/vec.h"
#include "scan/scan.h"

namespace scanmill {

struct Cloud {
  Vec3d origin;  // m, in the file's coordinates: what positions are relative to, so that float32 holds them
  Scan scan;
};

// Zero for a place within a kilometre of zero in each coordinate, where float32 is exact to 0.1 mm; else the place,
// rounded down to whole metres.
Vec3d cloudOrigin(const Vec3d& place);

// Whether a file is a cloud that scenes are made of: by its suffix, and a .ply by its header, which has vertices and no
// faces; where there is none, it is no cloud. Throws InputError for a .ply whose header is damaged.
bool isCloud(const std::filesystem::path& file);
// Whether readCloud() reads it: clouds, .bin and .npz.
bool isScan(const std::filesystem::path& file);
// ".pcd, .drc, ...": all that it reads.
std::string scanSuffixes();

// Reads a cloud. Columns of the table (scan/columns.h) are filled from what others call them: the classification of LAS
// is `label`; of a .ply `class`, `classification`, `semantic` and CloudCompare's `scalar_...` too. What the table lacks
// (red, green, blue, nx, ny, nz, gps_time) is kept as foreign columns. SemanticKITTI's labels are read with the scan
// that they stand beside. Throws InputError that names the file, and its line where it has lines.
Cloud readCloud(const std::filesystem::path& file);

}  // namespace scanmill
