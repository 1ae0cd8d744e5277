#pragma once

// A format turns a Scan into bytes and back: no disk. Adding one is a new file and a row in formats().

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "config/fields.h"
#include "scan/scan.h"

namespace scanmill {

class Format {
 public:
  virtual ~Format() = default;
  virtual std::string_view suffix() const = 0;  // "pcd", "drc", "csv": lower-case, no dot
  // Largest Euclidean error of a position that encode() makes, in metres; 0 for lossless.
  virtual double maxError() const = 0;
  virtual bool keepsMisses() const = 0;  // can it hold an organised scan?
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
