#pragma once

// Point clouds as scanners, surveys and other programs store them: .las, .ply, .pcd, .xyz and the formats of datasets;
// also single scans of public datasets: .bin and .pcd.bin.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "base/format_support.h"
#include "base/vec.h"
#include "scan/scan.h"

namespace scanmill {

struct Cloud {
  Vec3d origin = {};  // m, in the file's coordinates; positions in `scan` are relative to it, so that float32 suffices
  Scan scan = {};
  Pose worldFromFile = {};  // pose of the file's coordinates (VIEWPOINT of PCD); identity for other formats
  std::map<std::uint32_t, std::string> classNames = {};  // by label, as the file states them (LAS); may be empty
  LeftOut leftOut = {};                                  // what the reader leaves out; the caller warns of it
  std::string system = {};  // the coordinate system of a LAS (WKT or "EPSG:32632"); empty: not stated
};

// Returns the origin to use for a cloud near `position` (m): for each axis 0 if the position's coordinate is within 1
// km of 0, where float32 is exact to 0.1 mm; else the coordinate, rounded down to whole metres.
Vec3d cloudOrigin(const Vec3d& position);

// True if a file has the suffix of a point cloud, even if readCloud() only refuses it with advice (.laz, .e57, .pts,
// .ptx). A .ply counts as a cloud only if it exists, is not empty and has no faces; an .asc only if it lists points.
// Throws InputError for a .ply with a damaged header.
bool isCloud(const std::filesystem::path& file);
// True if a file can be a recorded scan: .bin, .npz (which readCloud() refuses), or a cloud other than .e57, .pts and
// .ptx. Throws InputError for a .ply with a damaged header.
bool isScan(const std::filesystem::path& file);
// Returns all suffixes that readCloud() reads: ".pcd, .drc, ...".
std::string scanSuffixes();

enum class CloudUnit {
  OfFile,  // coordinates in feet, as a LAS file can state, become metres; degrees are refused
  Metre,   // coordinates are metres, whatever unit the file states
};

// Reads a cloud. Columns of the table (scan/columns.h) are also found by the names that other programs give them, see
// kCloudColumns (formats/readers.h). Columns that are not in the table (red, green, blue, nx, ny, nz, gps_time) become
// foreign columns. For a scan of SemanticKITTI, the label file is also read. Throws an InputError that names the file
// and, in a text file, the line.
Cloud readCloud(const std::filesystem::path& file, CloudUnit unit = CloudUnit::OfFile);

// Returns the cloud's scan, and warns of what the reader left out. `what`: name of the file in the warning.
Scan scanOf(Cloud cloud, const std::string& what);

}  // namespace scanmill
