#pragma once

// What the colours of a picture mean.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scan/scan.h"
#include "scene/ontology.h"
#include "viewer/color_map.h"
#include "viewer/image.h"

namespace scanmill {

enum class ColorBy { Class, Intensity, Instance, Range, Ring, Time, Height, Return, Incidence, Error, Method };
constexpr std::array<std::string_view, 11> kColorNames{"class",  "intensity", "instance",  "range", "ring",  "time",
                                                       "height", "return",    "incidence", "error", "method"};

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
constexpr bool isNumeric(ColorBy by) {
  return by == ColorBy::Intensity || by == ColorBy::Range || by == ColorBy::Ring || by == ColorBy::Time ||
         by == ColorBy::Height || by == ColorBy::Incidence || by == ColorBy::Error;
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
  std::span<const float> error{};  // m, one per point; NaN: not known; empty: none
  std::string errorTitle{};        // "distance to the reference (m)"; empty: "error (m)"
  std::string method{};            // that made the scan; empty: not known
  Rgb methodColor = kNoValue;
  std::string whyNoError{};           // what it means that an error is not known: "no partner in the reference"
  std::optional<ScaleRange> scale{};  // in place of the ends that follow from the values
};

// Throws InputError where the scan lacks the column. Without a choice: class, else intensity, else range. The legend
// names the classes that the scan holds, in the order of their ids. A scale of intensity, range or height runs from the
// 1st to the 99th percentile, of every n-th point where there are millions (intensity by its square root: it falls with
// the square of the distance; range too: most points are near), one of ring or time from the least to the greatest
// value, one of incidence over all angles that there are, 0 to 90 deg, one of error from 0 to the 99th percentile, by
// its square root; beyond it, its ends' colours. Uses all threads. Without errors in the context, a point's is the
// difference of its distance from the sensor's origin and `range_true`; where beams start off that origin, or points
// are moved into the frame of the turn's start, that offset is in it.
Coloring colorScan(const Scan& scan, std::optional<ColorBy> colorBy, const ColorContext& context);
Coloring colorScan(const Scan& scan, std::optional<ColorBy> colorBy, const Ontology* ontology);

}  // namespace scanmill
