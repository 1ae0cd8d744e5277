#pragma once

// A format turns a Scan into bytes and back: no disk. Adding one is a new file and a row in formats().

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/fields.h"
#include "scan/scan.h"

namespace scanmill {

// What is known of a scan before it is made, for an estimate of its size.
struct ScanOutline {
  std::uint64_t points = 0;   // at most
  std::uint32_t rings = 0;    // of the sensor
  std::uint32_t columns = 0;  // of the sensor
  double reach = 0;           // m, largest absolute coordinate
  ColumnSet held;             // columns besides the position
};

class Format {
 public:
  virtual ~Format() = default;
  virtual std::string_view suffix() const = 0;  // "pcd", "drc", "csv": lower-case, no dot
  // Largest Euclidean error of a position that encode() makes, in metres; 0 for lossless.
  virtual double maxError() const = 0;
  virtual bool keepsMisses() const = 0;  // whether it can hold an organised scan
  // An upper bound of the bytes that encode() makes of such a scan.
  virtual double mostBytes(const ScanOutline& outline) const = 0;
  // Turns a scan into the bytes of a file; scans without points too. Several threads may call it at once. Throws Error
  // for an inconsistent scan (see requireConsistent()).
  virtual std::string encode(const Scan& scan) const = 0;
  // Turns the bytes of a file into a scan. Several threads may call it at once. Throws an InputError that begins with
  // `what`, the name of the bytes, for bytes that are truncated, damaged or no file of this format.
  virtual Scan decode(std::string_view bytes, const std::string& what) const = 0;
};

struct FormatEntry {
  std::string_view name;  // "pcd", "draco", "csv"
  std::string_view suffix;
  std::string_view summary;
  std::string_view keys;  // of its options, "name: default, what it is; ..."
  std::unique_ptr<Format> (*make)(Fields& options);
};

std::span<const FormatEntry> formats();
// The row with this name. Throws an InputError at `where`, with a suggestion, where there is none.
const FormatEntry& requireFormat(std::string_view name, const Location& where);
// The row with this suffix, for readers of files; null where there is none.
const FormatEntry* formatBySuffix(std::string_view suffix);

}  // namespace scanmill
