#pragma once

// Point clouds as scanners, surveys and other programs store them: .las, .ply, .pcd and the formats of datasets; also
// single scans of public datasets: .bin, .pcd.bin and .npz.

#include <filesystem>
#include <string>

#include "base/vec.h"
#include "scan/scan.h"

namespace scanmill {

struct Cloud {
  Vec3d origin;  // m, in the file's coordinates; positions in `scan` are relative to it, so that float32 suffices
  Scan scan;
};

// Returns the origin to use for a cloud near `place` (m). For each axis it is 0 if the place's coordinate is within 1
// km of 0, where float32 is exact to 0.1 mm; else it is the place's coordinate, rounded down to whole metres.
Vec3d cloudOrigin(const Vec3d& place);

// True if a file is a cloud that can be part of a scene, judged by its suffix. A .ply is a cloud if its header has no
// faces, but not if it does not exist or is empty. Throws InputError for a .ply with a damaged header.
bool isCloud(const std::filesystem::path& file);
// True if readCloud() can read the file: if isCloud() is true, or if its suffix is .bin or .npz. Throws as isCloud().
bool isScan(const std::filesystem::path& file);
// Returns all suffixes that readCloud() reads: ".pcd, .drc, ...".
std::string scanSuffixes();

// Reads a cloud. Some columns of the table (scan/columns.h) have other names in files: `label` is read from the
// classification of LAS, and in a .ply from `class`, `classification`, `semantic` and CloudCompare's `scalar_...`.
// Columns that are not in the table (red, green, blue, nx, ny, nz, gps_time) become foreign columns. With a scan of
// SemanticKITTI its label file is read too. Throws an InputError that names the file, and the line of a text file.
Cloud readCloud(const std::filesystem::path& file);

}  // namespace scanmill
