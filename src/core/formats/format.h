#pragma once

// A format turns a Scan into bytes and back, without disk access. To add one, add a file and a row in formats().
//
//   const Value defaults;
//   Fields options(defaults, "pcd");
//   const std::unique_ptr<Format> pcd = requireFormat("pcd", {}).make(options);
//   const Scan same = pcd->decode(pcd->encode(scan), "scan.pcd");

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "config/fields.h"
#include "scan/scan.h"

namespace scanmill {

// Properties of a scan that are known before it is made, for an estimate of its size.
struct ScanOutline {
  std::uint64_t points = 0;   // largest number of points
  std::uint32_t rings = 0;    // number of the sensor's rings
  std::uint32_t columns = 0;  // number of the sensor's columns
  double reach = 0;           // m, largest absolute value of a coordinate
  ColumnSet held;             // columns of the scan, besides the position
};

class Format {
 public:
  virtual ~Format() = default;
  // Returns the largest Euclidean error of a position that encode() makes (m); 0: the format is lossless.
  virtual double maxError() const { return 0; }
  virtual bool keepsMisses() const { return true; }  // true if encode() can store an organised scan
  // Returns an upper bound of the bytes that encode() produces for a scan with this outline.
  virtual double mostBytes(const ScanOutline& outline) const = 0;
  // Turns a scan, also one without points, into the bytes of a file. Several threads may call this at once. Throws
  // Error for an inconsistent scan (see requireConsistent()).
  virtual std::string encode(const Scan& scan) const = 0;
  // Turns the bytes of a file into a scan. Several threads may call this at once. If the bytes are truncated, damaged
  // or not a file of this format, throws an InputError that begins with `what`, the name of the bytes.
  virtual Scan decode(std::string_view bytes, const std::string& what) const = 0;
};

struct FormatEntry {
  std::string_view name;    // "pcd", "draco", "csv"
  std::string_view suffix;  // "pcd", "drc", "csv": lower-case, no dot
  std::string_view summary;
  std::string_view keys;  // the options, a line for each: "name: default, meaning"
  std::unique_ptr<Format> (*make)(Fields& options);
};

std::span<const FormatEntry> formats();
// Returns the row with this name. Throws an InputError at `where`, with a suggestion, if there is none.
const FormatEntry& requireFormat(std::string_view name, const Location& where);
// Returns the row with this suffix, for readers of files; null if there is none.
const FormatEntry* formatBySuffix(std::string_view suffix);

}  // namespace scanmill
