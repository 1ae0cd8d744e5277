#pragma once

// Colours the points of a scan, and describes the colours in a legend.

#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scan/scan.h"
#include "scene/ontology.h"
#include "viewer/color_map.h"
#include "viewer/view_camera.h"

namespace scanmill {

// The name of the quantity by which points are coloured: a column of the table (scan/columns.h; "class" for the label),
// a foreign column of the scan, or a quantity that is computed for each point (range, height, error).
class ColorBy {
 public:
  explicit ColorBy(std::string name) : name_(std::move(name)) {}
  explicit ColorBy(const Column& column) : ColorBy(std::string(titleOf(column))) {}
  const std::string& name() const { return name_; }
  auto operator<=>(const ColorBy&) const = default;  // NOLINT(modernize-use-nullptr): the compiler writes the 0

  static std::string_view titleOf(const Column& column) {
    return column.display.title.empty() ? column.name : column.display.title;
  }
  // Returns the quantity's row in the table of columns; null if it is not a column.
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

// Returns the names of all quantities except foreign columns, in the order of their keys in the viewer (1 to 9, then 0,
// which select the first ten); columns without a key come last.
const std::vector<std::string>& colorNames();

// True if the scan can be coloured by this quantity. `hasErrors`: errors of the points are known.
bool hasColor(const Scan& scan, const ColorBy& by, bool hasErrors);

// Returns the quantities of colorNames(), followed by the scan's foreign columns.
std::vector<ColorBy> colorsOf(const Scan& scan);

struct LegendEntry {
  std::string name;
  Rgb color{};
  std::int64_t id = -1;      // class id; -1 if the entry is not a class
  std::uint64_t points = 0;  // number of finite points of this colour
};

// The values at the ends of a colour scale.
struct ScaleRange {
  double low = 0, high = 1;
  bool operator==(const ScaleRange&) const = default;
};

// True if the quantity is a number, for which colours form a scale.
inline bool isNumeric(const ColorBy& by) {
  return by != kByClass && by != kByInstance && by != kByReturn && by != kByCause;
}

// Describes colours: either a list of named colours, or a scale from `low` to `high`.
struct Legend {
  std::string title{};  // quantity and unit, such as "range (m)"
  std::vector<LegendEntry> entries{};
  bool scale = false;
  double low = 0, high = 0;
  double power = 1;           // the colour at position t of the map shows the value low + (high - low) * t^power
  bool integers = false;      // true: the values are integers
  bool endsChosen = false;    // true: the ends of the scale are chosen by the user, not computed from the values
  std::uint64_t unknown = 0;  // number of finite points whose value is unknown; they have the colour kNoValue
  std::string whyUnknown{};   // reason why values are unknown, such as "no partner in the reference"; may be empty
};

struct Coloring {
  std::vector<Rgb> colors;  // one per point
  Legend legend;
};

// Data for colorScan() that are not part of a scan.
struct ColorContext {
  const Ontology* ontology = nullptr;
  std::span<const float> error{};  // error of each point (m); NaN: unknown; empty: no errors
  // Title of the legend for errors, such as "distance to the reference (m)"; empty: "error (m)".
  std::string errorTitle{};
  std::string whyNoError{};           // reason why errors are unknown, such as "no partner in the reference"
  std::optional<ScaleRange> scale{};  // ends of the scale that the user has chosen; absent: computed from the values
  std::optional<CloseUp> closeUp{};   // the legend counts only points in this ball; absent: it counts all points
};

// Colours the points of a scan by `colorBy` or, if this is absent, by the first of class, intensity and range that the
// scan has. Throws InputError if the scan does not have the column.
//
// A legend of classes lists those that occur in the scan, sorted by id. The table of columns states which values a
// column's scale covers: minimum to maximum, 1st to 99th percentile (computed from every n-th point if there are
// millions), or all valid values. For foreign columns, range and height, the scale covers the 1st to 99th percentile.
// For intensity, range and error, colours are proportional to the square root of the value, since intensity decreases
// with the square of the distance, and most points are near. The scale of errors starts at 0. Values beyond a scale get
// the colour of its nearer end.
//
// If the context has no errors, a point's error is the absolute difference between its distance from the sensor's
// origin and `range_true`. This is inexact if beams do not start at the sensor's origin, or if points are deskewed. If
// a scan has no column `return`, all points are first returns, unless the scan is organised in several planes, one per
// return. Uses all threads.
Coloring colorScan(const Scan& scan, const std::optional<ColorBy>& colorBy, const ColorContext& context);

// The colour of an id, and the number of counted elements with this id.
struct ColorOfId {
  Rgb color{};
  std::uint64_t count = 0;
};

// Appends to `colors` the colour of each of `elements` elements. idOf(i) returns the id of element i, and colorOf(id)
// the id's colour. Returns, by id, the colour and the number of elements for which isCounted(i) is true; omits zeros.
std::map<std::uint32_t, ColorOfId> paint(std::size_t elements, const auto& idOf, const auto& colorOf,
                                         const auto& isCounted, std::vector<Rgb>& colors) {
  std::map<std::uint32_t, ColorOfId> ids;
  colors.reserve(colors.size() + elements);
  auto current = ids.end();  // the entry of the last element, since neighbouring elements mostly have the same id
  for (std::size_t i = 0; i < elements; ++i) {
    const std::uint32_t id = idOf(i);
    if (current == ids.end() || current->first != id) current = ids.try_emplace(id, ColorOfId{colorOf(id), 0}).first;
    colors.push_back(current->second.color);
    current->second.count += isCounted(i) ? 1 : 0;
  }
  std::erase_if(ids, [](const auto& entry) { return entry.second.count == 0; });
  return ids;
}

// Return the legends of elements that are coloured by class or by instance, from the ids that paint() returns.
Legend classLegend(const std::map<std::uint32_t, ColorOfId>& classes, const Ontology* ontology);
Legend instanceLegend(std::map<std::uint32_t, ColorOfId> instances);

struct ScaleTick {
  double position = 0;  // position on the bar, from 0 at its low end to 1 at its high end
  std::string text;
};

// Returns at most six ticks at multiples of 1, 2 or 5 times a power of ten; if the scale has no such multiple, ticks at
// its ends. Values that are integers have integer ticks. A scale with a single value has one tick, in the middle.
std::vector<ScaleTick> scaleTicks(const Legend& legend);

// Returns the legend's title, with a remark if colours are not proportional to values or the user has chosen the ends,
// such as "range (m), by its square root".
std::string scaleTitle(const Legend& legend);

}  // namespace scanmill
