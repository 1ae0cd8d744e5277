#pragma once

// Colours the points of a scan and describes the colours in a legend.

#include <compare>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scan/scan.h"
#include "scene/ontology.h"
#include "viewer/color_map.h"
#include "viewer/image.h"

namespace scanmill {

// The name of the quantity that colours show: a column of the table (scan/columns.h; "class" for the label), a foreign
// column of the scan, or a quantity that is computed for each point: range, height, error.
class ColorBy {
 public:
  explicit ColorBy(std::string name) : name_(std::move(name)) {}
  explicit ColorBy(const Column& column) : ColorBy(std::string(titleOf(column))) {}
  const std::string& name() const { return name_; }
  auto operator<=>(const ColorBy&) const = default;  // NOLINT(modernize-use-nullptr): nobody writes one

  static std::string_view titleOf(const Column& column) {
    return column.display.title.empty() ? column.name : column.display.title;
  }
  // Returns the quantity's row in the table of columns; null if it has none.
  const Column* column() const;

 private:
  std::string name_;
};

inline const ColorBy kByClass{kLabel.row};
inline const ColorBy kByInstance{kInstance.row};
inline const ColorBy kByIntensity{kIntensity.row};
inline const ColorBy kByReturn{kReturn.row};
inline const ColorBy kByCause{kCause.row};
inline const ColorBy kByRange{"range"};
inline const ColorBy kByHeight{"height"};
inline const ColorBy kByError{"error"};

// Returns the names of all quantities except foreign columns. The viewer's keys 1 to 9 and 0 choose the first ten.
const std::vector<std::string>& colorNames();

// True if the scan can be coloured by this quantity. `errorKnown`: the errors, which no scan contains, are known.
bool hasColor(const Scan& scan, const ColorBy& by, bool errorKnown);

// Returns the names of colorNames(), then the scan's foreign columns.
std::vector<ColorBy> colorsOf(const Scan& scan);

struct LegendEntry {
  std::string name;
  Rgb color{};
  std::int64_t id = -1;      // class id; -1: none
  std::uint64_t points = 0;  // number of finite points of this colour
};

// The ends of a scale.
struct ScaleRange {
  double low = 0;
  double high = 1;
  bool operator==(const ScaleRange&) const = default;
};

// True if the quantity is a number, which is coloured by a scale.
inline bool isNumeric(const ColorBy& by) {
  return by != kByClass && by != kByInstance && by != kByReturn && by != kByCause;
}

// Either named colours or a scale from `low` to `high`.
struct Legend {
  std::string title;  // "range (m)"
  std::vector<LegendEntry> entries;
  bool scale = false;
  double low = 0;
  double high = 0;
  double power = 1;           // the map's colour at t means the value low + (high - low) * t^power
  bool integers = false;      // the values of the scale are whole numbers
  bool held = false;          // the ends of the scale were given and do not follow from the values
  std::uint64_t unknown = 0;  // number of finite points whose value is unknown; their colour is kNoValue
  std::string whyUnknown{};   // "no partner in the reference"; may be empty
};

struct Coloring {
  std::vector<Rgb> colors;  // one per point
  Legend legend;
};

// Input of colorScan() that no scan contains.
struct ColorContext {
  const Ontology* ontology = nullptr;
  std::span<const float> error{};     // m, one per point; NaN: unknown; empty: no errors are given
  std::string errorTitle{};           // "distance to the reference (m)"; empty: "error (m)"
  std::string whyNoError{};           // the meaning of an unknown error: "no partner in the reference"
  std::optional<ScaleRange> scale{};  // the ends of the scale; absent: they follow from the values
};

// Colours the scan's points by `colorBy`; if it is absent by class, else by intensity, else by range. Throws InputError
// if the scan lacks the column. The legend lists the classes that occur in the scan, in the order of their ids. A
// column's row of the table says what its scale spans: the least to the greatest value, the 1st to the 99th percentile
// (of every n-th point if there are millions), or all valid values; foreign columns, range and height span percentiles.
// The scales of intensity, range and error follow the square root: intensity falls with the square of the distance, and
// most points are near. The scale of errors starts at 0. Values beyond a scale get the colour of its nearer end. Uses
// all threads. If the context has no errors, a point's error is its distance from the sensor's origin minus
// `range_true`; if beams start off that origin, or points are moved into the frame of the revolution's start, the error
// includes that offset. A scan without a column `return` has only first returns, unless it is organised in several
// planes, one per return.
Coloring colorScan(const Scan& scan, const std::optional<ColorBy>& colorBy, const ColorContext& context);
Coloring colorScan(const Scan& scan, const std::optional<ColorBy>& colorBy, const Ontology* ontology);

}  // namespace scanmill
