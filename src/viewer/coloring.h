#pragma once

// What the colours of a picture mean.

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scan/scan.h"
#include "scene/ontology.h"
#include "viewer/image.h"

namespace scanmill {

enum class ColorBy { Class, Intensity, Instance, Range, Ring, Time, Height };
constexpr std::array<std::string_view, 7> kColorNames{"class", "intensity", "instance", "range",
                                                      "ring",  "time",      "height"};

struct LegendEntry {
  std::string name;
  Rgb color{};
};

// Either named colours or a scale from `low` to `high`.
struct Legend {
  std::string title;  // "range (m)"
  std::vector<LegendEntry> entries;
  bool scale = false;
  double low = 0;
  double high = 0;
  double power = 1;  // the colour at t of the map stands for low + (high - low) * t^power
};

struct Coloring {
  std::vector<Rgb> colors;  // one per point
  Legend legend;
};

// Throws InputError where the scan lacks the column. Without a choice: class, else intensity, else range. The legend
// names the classes that the scan holds, in the order of their ids. A scale of intensity, range or height runs from the
// 1st to the 99th percentile (intensity by its square root: it falls with the square of the distance), one of ring or
// time from the least to the greatest value; beyond it, its ends' colours.
Coloring colorScan(const Scan& scan, std::optional<ColorBy> colorBy, const Ontology* ontology);

}  // namespace scanmill
