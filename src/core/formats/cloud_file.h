#pragma once

// Point clouds as scanners, surveys and other programs store them: .las, .ply, .pcd and the formats of datasets; also
// single scans of public datasets: .bin, .pcd.bin and .npz.

#include <filesystem>
#include <string>

#include "base/vec.h"
#include "scan/scan.h"

namespace scanmill {

struct Cloud {
  Vec3d origin;  // m, in the file's coordinates; positions are relative to it, so that float32 is exact enough
  Scan scan;
};

// Returns the origin of a cloud near `place`. Each of its coordinates is 0 if that of the place lies within a kilometre
// of 0, where float32 is exact to 0.1 mm; else it is the place's, rounded down to whole metres.
Vec3d cloudOrigin(const Vec3d& place);

// True if a file is a cloud that can be part of a scene: by its suffix, and a .ply by its header, which must have no
// faces. False for a .ply that does not exist or is empty. Throws InputError for a .ply whose header is damaged.
bool isCloud(const std::filesystem::path& file);
// True if readCloud() reads the file: clouds, .bin and .npz.
bool isScan(const std::filesystem::path& file);
// Returns all suffixes that readCloud() reads: ".pcd, .drc, ...".
std::string scanSuffixes();

// Reads a cloud. Columns of the table (scan/columns.h) are filled from other names, too: `label` from the
// classification of LAS, and of a .ply from `class`, `classification`, `semantic` and CloudCompare's `scalar_...`.
// Columns that the table lacks (red, green, blue, nx, ny, nz, gps_time) become foreign columns. SemanticKITTI's label
// file is read with the scan that it stands beside. Throws an InputError that names the file, and the line of a text
// file.
Cloud readCloud(const std::filesystem::path& file);

}  // namespace scanmill
