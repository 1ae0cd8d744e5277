#pragma once

// Functions that read files of scans and point clouds, and functions that create the formats in formats(). Each is
// defined in the file that is named after its format: readPcd() in pcd_reader.cpp, makePcd() in pcd.cpp.

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/format_support.h"
#include "formats/cloud_file.h"
#include "formats/format.h"
#include "scan/scan.h"

namespace scanmill {

// The start of a comment in the header of PCDs that this program has written. The line states the sensor's numbers of
// rings and columns, and whether the scan is organised or dense. Other readers ignore it.
constexpr std::string_view kPcdSensorComment = "# scanmill sensor:";

// Name of the extra bytes of LAS in which this program exports exact intensities.
constexpr std::string_view kLasExactIntensity = "intensity_f";

std::unique_ptr<Format> makePcd(Fields& options);
std::unique_ptr<Format> makeDraco(Fields& options);
std::unique_ptr<Format> makeCsv(Fields& options);

// The contents that each reader reads and leaves out.
extern const FormatSupport kPcdFormat;
extern const FormatSupport kCsvFormat;
extern const FormatSupport kDracoFormat;
extern const FormatSupport kLasFormat;
extern const FormatSupport kPlyCloudFormat;
extern const FormatSupport kPointRecordsFormat;

// The readers below find columns by the names in kCloudColumns; other columns become foreign. All throw an InputError
// that begins with `what`, the name of the bytes, and states the line if the bytes are text.
//
// If `exact` is true, positions are read in double precision and are relative to cloudOrigin() of the first finite
// point (cloud_file.h). If it is false, positions are the file's numbers in float32, and the origin is zero.

// Reads any valid PCD. Fields may be in any order and of any numeric type whose values fit the column. Fields of
// several values a point are left out. Cloud::worldFromFile is the VIEWPOINT, or the identity if its numbers are all 0.
// Quaternions whose length is 0.99 to 1.01 are normalised, all others refused.
Cloud readPcd(std::string_view bytes, const std::string& what, bool exact = true);

// Reads text with one line per point. Commas, semicolons, tabs or blanks separate the values. The first line names the
// columns; it may be absent if there are three columns: x, y and z. Lines that are empty or begin with # or // are
// skipped, unless they name the columns. Columns of the table are read in their types, others as doubles.
Cloud readCsv(std::string_view bytes, const std::string& what, bool exact = true);

// Reads any Draco point cloud that has positions. Its other attributes are recognised by their metadata entry "name".
// The origin is zero.
Cloud readDraco(std::string_view bytes, const std::string& what);

// Reads the points of LAS 1.0 to 1.4, point formats 0 to 10 ("LAS Specification 1.4 - R15", American Society for
// Photogrammetry and Remote Sensing, 2019), except points marked as withheld; extra bytes are columns. If `unit` is
// OfFile, refuses coordinates that are degrees, earth-centred or in unknown units, and warns of Mercator projections.
Cloud readLas(std::string_view bytes, const std::string& what, CloudUnit unit = CloudUnit::OfFile);

// Reads the points of a PLY file (the element `vertex`). Properties that are lists are left out.
Cloud readPly(const std::filesystem::path& file);

// The names of columns, in lower case and without CloudCompare's prefix `scalar_`. Each string of `keywords.read` lists
// the names of one column, beginning with its own. A scene does not need the columns in `keywords.unused`.
extern const FormatSupport kCloudColumns;

// Returns the name of the column that `name` stands for ("label" for "scalar_Classification"). If `keywords.read` lacks
// the name, returns it in lower case and without `scalar_`.
std::string columnMeant(std::string_view name);

// Converts foreign columns whose names stand for columns of the table (see columnMeant()) to these columns, if the scan
// lacks them; an intensity column of zeros counts as lacking. Of several foreign columns for the same column, the first
// with the table's own name or, if there is none, the first is converted. Negative instance numbers mean "no instance"
// and become 0; if there are any, all other instance numbers increase by 1. The labels -1 and -100 become 0, or 65535
// if the column has a 0, which may be a class. If a number does not fit the column's type, the foreign column stays and
// is counted in cloud.leftOut; if it has the table's own name and `where` names a file, throws an InputError instead.
void adoptColumns(Cloud& cloud, const Location& where);

// Sets the positions of a scan to `exact` (m) and the cloud's origin to cloudOrigin() of the first finite position.
void setPositions(const std::vector<Vec3d>& exact, Cloud& cloud);

// The next functions read scans of KITTI, SemanticKITTI and nuScenes (bare float32 records) and their label files.

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
// the array `data` of one uint16 per point: 1000 * class + index. The instance is the complete uint16, since indices
// count within one class; it is 0 where the index is 0. Throws like addSemanticKittiLabels().
void addPanopticLabels(std::string_view bytes, const std::string& what, Scan& scan);

// Returns the label file of a scan of SemanticKITTI: for velodyne/000000.bin the file labels/000000.label beside the
// folder velodyne; empty if there is none.
std::filesystem::path labelsBeside(const std::filesystem::path& scan);

}  // namespace scanmill
