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

// What is known of a scan before it is made.
struct ScanOutline {
  std::uint64_t points = 0;   // at most
  std::uint32_t rings = 0;    // of the sensor
  std::uint32_t columns = 0;  // of the sensor
  double reach = 0;           // m, of the largest coordinate
  ColumnSet held;             // besides the position
};

class Format {
 public:
  virtual ~Format() = default;
  virtual std::string_view suffix() const = 0;  // "pcd", "drc", "csv": lower-case, no dot
  // Largest Euclidean error of a position that encode() makes, in metres; 0 for lossless.
  virtual double maxError() const = 0;
  virtual bool keepsMisses() const = 0;  // can it hold an organised scan?
  // Upper bound of the bytes that encode() makes of such a scan.
  virtual double mostBytes(const ScanOutline& outline) const = 0;
  // Called from several threads at once. Empty scans are encoded too.
  virtual std::string encode(const Scan& scan) const = 0;
  // `what` names the bytes in errors (InputError): truncated or foreign bytes never crash.
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
const FormatEntry& requireFormat(std::string_view name, const Location& where);
// By file suffix, with default options, for readers. Null where unknown.
const FormatEntry* formatBySuffix(std::string_view suffix);

}  // namespace scanmill
