#pragma once

// Readers of the kinds of files in which scans and point clouds are stored. Each is defined in the file of its kind:
// readPcd() in pcd_reader.cpp.

#include <filesystem>
#include <string>
#include <string_view>

#include "formats/cloud_file.h"
#include "scan/scan.h"

namespace scanmill {

// The start of a comment in the header of PCDs that this program has written. The line states the sensor's numbers of
// rings and columns, and whether the scan is organised or dense. Other readers ignore it.
constexpr std::string_view kPcdSensorComment = "# scanmill sensor:";

// Reads any valid PCD. Fields may be in any order and of any numeric type whose values fit the column. Fields that are
// not in the table of columns become foreign columns. If there is no field `intensity`, that column is read from
// `reflectivity`. Throws an InputError that begins with `what`, the name of the bytes. If `origin` is not null, it is
// set to cloudOrigin() of the first finite point (formats/cloud_file.h), and positions are relative to it.
Scan readPcd(std::string_view bytes, const std::string& what, Vec3d* origin = nullptr);

// Reads any Draco point cloud that has positions. Its other attributes are recognised by their metadata entry "name".
// Throws an InputError that begins with `what`, the name of the bytes.
Scan readDraco(std::string_view bytes, const std::string& what);

// Reads a scan from a NumPy archive (formats/npy.h). Its positions are the array `xyz` or `points`, of shape (N, 3) or
// (rings, columns, 3); misses of an array of the second shape are NaN. A fourth and a fifth number per point are
// intensity and ring. Every other array with one number per point becomes the column of its name: `label` if its name
// is `labels`, `classes` or `semantic`; a foreign column if the table of columns lacks the name. All other arrays are
// left out. Throws an InputError that begins with `what` if the bytes are not a ZIP archive, if an array is damaged, in
// Fortran's order or big-endian, if the positions are missing or not numbers, or if a column of the table has another
// shape than the points.
Scan readNpz(std::string_view bytes, const std::string& what);

// Reads the points of LAS 1.0 to 1.4, point formats 0 to 10 ("LAS Specification 1.4 - R15", American Society for
// Photogrammetry and Remote Sensing, 2019), except points marked as withheld. Coordinates are taken as metres, the unit
// of nearly all files; a unit in the file's coordinate system is ignored. Throws an InputError that begins with `what`,
// the name of the bytes, if they are not LAS, of another version, truncated, or compressed (LAZ).
Cloud readLas(std::string_view bytes, const std::string& what);

// Reads the points of a PLY file (the element `vertex`). For the names of columns see readCloud() in
// formats/cloud_file.h. Throws an InputError with the file and line.
Cloud readPly(const std::filesystem::path& file);

}  // namespace scanmill
