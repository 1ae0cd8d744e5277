#pragma once

// What the colours of a picture mean.

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

// What colours show, by its name: a column of the table (scan/columns.h; "class" for the label), a foreign column of
// the scan, or one of the figures that follow from what is known of a point: range, height, error.
class ColorBy {
 public:
  explicit ColorBy(std::string name) : name_(std::move(name)) {}
  explicit ColorBy(const Column& column) : ColorBy(std::string(titleOf(column))) {}
  const std::string& name() const { return name_; }
  auto operator<=>(const ColorBy&) const = default;  // NOLINT(modernize-use-nullptr): nobody writes one

  static std::string_view titleOf(const Column& column) {
    return column.display.title.empty() ? column.name : column.display.title;
  }
  // The row of the table of columns; null where there is none.
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

// The names of all but foreign columns. The first ten are those of the viewer's keys 1 to 9 and 0.
const std::vector<std::string>& colorNames();

// Whether the scan can be coloured so, where errors, which a scan does not say of itself, are known or not.
bool hasColor(const Scan& scan, const ColorBy& by, bool errorKnown);

// The names of colorNames(), then the scan's foreign columns.
std::vector<ColorBy> colorsOf(const Scan& scan);

struct LegendEntry {
  std::string name;
  Rgb color{};
  std::int64_t id = -1;      // class id; -1: none
  std::uint64_t points = 0;  // finite ones of this colour
};

// The ends of a scale.
struct ScaleRange {
  double low = 0;
  double high = 1;
  bool operator==(const ScaleRange&) const = default;
};

// Colours by numbers, which have a scale.
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
  double power = 1;           // the colour at t of the map stands for low + (high - low) * t^power
  bool integers = false;      // of a scale: its values are whole numbers
  bool held = false;          // of a scale: its ends were given, and do not follow from the values
  std::uint64_t unknown = 0;  // finite points whose value is not known: they have the colour kNoValue
  std::string whyUnknown{};   // "no partner in the reference"; may be empty
};

struct Coloring {
  std::vector<Rgb> colors;  // one per point
  Legend legend;
};

// What a scan does not say of itself.
struct ColorContext {
  const Ontology* ontology = nullptr;
  std::span<const float> error{};     // m, one per point; NaN: not known; empty: none
  std::string errorTitle{};           // "distance to the reference (m)"; empty: "error (m)"
  std::string whyNoError{};           // what it means that an error is not known: "no partner in the reference"
  std::optional<ScaleRange> scale{};  // in place of the ends that follow from the values
};

// Throws InputError where the scan lacks the column. Without a choice: class, else intensity, else range. The legend
// names the classes that the scan holds, in the order of their ids. The scale of a column is what its row of the table
// says: from the least to the greatest value, or from the 1st to the 99th percentile (of every n-th point where there
// are millions), or over all values that are valid; foreign columns, range and height have percentiles. Intensity,
// range and error go by their square roots: intensity falls with the square of the distance, and most points are near.
// The scale of errors starts at 0. Values beyond a scale have its ends' colours. Uses all threads. Without errors in
// the context, a point's is the difference of its distance from the sensor's origin and `range_true`; where beams start
// off that origin, or points are moved into the frame of the revolution's start, that offset is in it. A scan without a
// column `return` has first returns only, unless it is organised in several planes, which tell the return.
Coloring colorScan(const Scan& scan, const std::optional<ColorBy>& colorBy, const ColorContext& context);
Coloring colorScan(const Scan& scan, const std::optional<ColorBy>& colorBy, const Ontology* ontology);

}  // namespace scanmill
