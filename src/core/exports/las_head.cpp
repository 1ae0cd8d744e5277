// The header and the variable length records of LAS: "LAS Specification 1.4 - R15", American Society for Photogrammetry
// and Remote Sensing, 2019.

#include "exports/las_head.h"

#include <fmt/core.h>

#include "config/version.h"
#include "formats/little_endian.h"

namespace scanmill {

namespace {

constexpr std::uint16_t kHeaderBytes = 375;
constexpr std::uint8_t kFormat = 6;
constexpr std::uint16_t kReturnsAreMadeUp = 1 << 3;  // bit of the global encoding: return numbers are synthetic
constexpr std::uint16_t kCoordinatesAreWkt = 1 << 4;

// A local coordinate system without a position on the earth, in the notation of "OpenGIS Implementation Specification:
// Coordinate Transformation Services", OGC 01-009, 7.2, in which a local datum may have the types 10000 to 32767. The z
// axis is left out, because PROJ, which most readers use, refuses a local system with three axes.
constexpr std::string_view kCoordinateSystem =
    R"(LOCAL_CS["scanmill world",LOCAL_DATUM["scanmill world",32767],UNIT["metre",1],AXIS["x",EAST],AXIS["y",NORTH]])";

// Appends a text as a field of `length` bytes: truncated, or padded with zeros.
void putText(std::string text, std::size_t length, std::string& bytes) {
  text.resize(length, '\0');
  bytes += text;
}

// Appends a variable length record.
void putRecord(const char* user, std::uint16_t id, const char* description, std::string_view data, std::string& bytes) {
  putNumber(std::uint16_t{0}, bytes);
  putText(user, 16, bytes);
  putNumber(id, bytes);
  putNumber(static_cast<std::uint16_t>(data.size()), bytes);
  putText(description, 32, bytes);
  bytes += data;
}

// Returns the classification lookup: 256 entries of 16 bytes, each with a class id and 15 characters of the class's
// name.
std::string classNames(const Ontology& classes) {
  std::string bytes;
  for (std::uint16_t id = 0; id <= kMostLasClass; ++id) {
    const SemanticClass* const known = classes.find(id);
    putNumber(static_cast<std::uint8_t>(id), bytes);
    putText(known == nullptr ? "" : known->name, 15, bytes);
  }
  return bytes;
}

std::uint8_t extraType(ColumnType type) {
  switch (type) {
    case ColumnType::UInt8:
      return 1;
    case ColumnType::UInt16:
      return 3;
    case ColumnType::UInt32:
      return 5;
    case ColumnType::Float32:
      return 9;
  }
  return 0;
}

// Returns the descriptors of the extra bytes, 192 bytes for each column.
std::string descriptors(std::span<const LasExtra> extra) {
  std::string bytes;
  for (const LasExtra& column : extra) {
    putNumber(std::uint16_t{0}, bytes);
    putNumber(extraType(column.type), bytes);
    putNumber(std::uint8_t{0}, bytes);  // options: no value for "no data", no range, no scale and no offset
    putText(std::string(column.name), 32, bytes);
    bytes.append(4 + 5 * 24, '\0');
    putText(column.unit.empty() ? "" : fmt::format("unit: {}", column.unit), 32, bytes);
  }
  return bytes;
}

}  // namespace

std::string lasHead(const LasPoints& points, std::span<const LasExtra> extra, const Ontology& classes) {
  std::string records;
  putRecord("LASF_Projection", 2112, "coordinate system, WKT", std::string(kCoordinateSystem) + '\0', records);
  putRecord("LASF_Spec", 0, "classification lookup", classNames(classes), records);
  if (!extra.empty()) putRecord("LASF_Spec", 4, "extra bytes", descriptors(extra), records);
  std::size_t pointBytes = LasPoints::kBytes;
  for (const LasExtra& column : extra) pointBytes += bytesOf(column.type);

  std::string bytes = "LASF";
  putNumber(std::uint16_t{0}, bytes);  // file source ID: none
  putNumber(static_cast<std::uint16_t>(kCoordinatesAreWkt | (points.returnsAreMadeUp ? kReturnsAreMadeUp : 0)), bytes);
  bytes.append(16, '\0');  // project ID: none
  putNumber(std::uint8_t{1}, bytes);
  putNumber(std::uint8_t{4}, bytes);
  putText("SIMULATION", 32, bytes);
  putText(fmt::format("scanmill {}", kVersion), 32, bytes);
  putNumber(std::uint16_t{1}, bytes);  // day and year of creation: mandatory, but always 2000-01-01
  putNumber(std::uint16_t{2000}, bytes);
  putNumber(kHeaderBytes, bytes);
  putNumber(static_cast<std::uint32_t>(kHeaderBytes + records.size()), bytes);
  putNumber(static_cast<std::uint32_t>(extra.empty() ? 2 : 3), bytes);
  putNumber(kFormat, bytes);
  putNumber(static_cast<std::uint16_t>(pointBytes), bytes);
  bytes.append(4 + 5 * 4, '\0');  // counts of points as in earlier versions: 0
  for (int axis = 0; axis < 3; ++axis) putNumber(points.step, bytes);
  const std::array<double, 3> offset{points.offset.x, points.offset.y, points.offset.z};
  for (const double along : offset) putNumber(along, bytes);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto placeOf = [&](std::int32_t steps) { return points.count == 0 ? 0 : steps * points.step + offset[axis]; };
    putNumber(placeOf(points.greatest[axis]), bytes);
    putNumber(placeOf(points.least[axis]), bytes);
  }
  putNumber(std::uint64_t{0}, bytes);  // start of the waveform data: none
  putNumber(std::uint64_t{0}, bytes);  // start of the extended records after the points: none
  putNumber(std::uint32_t{0}, bytes);
  putNumber(points.count, bytes);
  for (const std::uint64_t count : points.byReturn) putNumber(count, bytes);
  return bytes + records;
}

}  // namespace scanmill
