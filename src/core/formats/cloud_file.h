#pragma once

// Clouds of points as scanners, surveys and other programs leave them: .las, .ply, .pcd, and the formats of datasets.

#include <filesystem>

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

// Whether a file is read as a cloud: by its suffix, and a .ply by its header, which has vertices and no faces; where
// there is none, it is no cloud. Throws InputError for a .ply whose header is damaged.
bool isCloud(const std::filesystem::path& file);

// Reads a cloud. Columns of the table (scan/columns.h) are filled from what others call them: the classification of LAS
// is `label`; of a .ply `class`, `classification`, `semantic` and CloudCompare's `scalar_...` too. What the table lacks
// (red, green, blue, nx, ny, nz, gps_time) is kept as foreign columns. Throws InputError that names the file, and its
// line where it has lines.
Cloud readCloud(const std::filesystem::path& file);

}  // namespace scanmill
