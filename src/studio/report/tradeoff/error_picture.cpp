#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "report/tradeoff/report.h"
#include "viewer/color_map.h"
#include "viewer/picture.h"

namespace scanmill {

namespace {

constexpr double kLeastError = 1e-3;  // errors below this bound (m) get the same colour
constexpr double kDecades = 3;        // from kLeastError to the end of the colours
constexpr Rgb kFalseNegativeColor{255, 70, 70};
constexpr Rgb kFalsePositiveColor{255, 255, 255};
constexpr Rgb kOtherLabelColor{255, 150, 220};

// Returns the colour of a range error (m).
Rgb errorColor(double error) {
  // Fraction of the colour map, at its dark end, that is not used, since its colours can hardly be seen.
  constexpr double kDarkest = 0.15;
  return viridis(kDarkest + (1 - kDarkest) * std::log10(std::max(error, kLeastError) / kLeastError) / kDecades);
}

}  // namespace

std::string drawErrors(const TrueShot& truth, const Hits& tested) {
  const Hits& real = truth.truth.hits;
  Scan scan;
  scan.rings = real.rings;
  scan.columns = real.columns;
  Coloring coloring;
  // Adds the point at a range (m) along a beam to `scan`, and its colour to `coloring`.
  const auto addPoint = [&](std::size_t beam, double range, const Rgb& color) {
    scan.position.push_back(Vec3f(truth.shot.beams->originOf(beam) + truth.shot.beams->direction[beam] * range));
    coloring.colors.push_back(color);
  };
  for (std::size_t i = 0; i < real.size(); ++i) {
    if (!real.hit(i) && !tested.hit(i)) continue;
    if (!tested.hit(i)) {
      addPoint(i, truth.truth.range[i], kFalseNegativeColor);
    } else if (!real.hit(i)) {
      addPoint(i, double{tested.range[i]}, kFalsePositiveColor);
    } else if (real.semantic[i] != tested.semantic[i] || real.instance[i] != tested.instance[i]) {
      addPoint(i, truth.truth.range[i], kOtherLabelColor);
    } else {
      addPoint(i, truth.truth.range[i], errorColor(std::abs(double{tested.range[i]} - truth.truth.range[i])));
    }
  }
  coloring.legend.title = "range error";
  for (const auto& [name, error] :
       {std::pair{"1 mm or less", 1e-3}, {"1 cm", 1e-2}, {"10 cm", 0.1}, {"1 m or more", 1.0}}) {
    coloring.legend.entries.push_back({name, errorColor(error)});
  }
  for (const auto& [name, color] : {std::pair{"other label", kOtherLabelColor},
                                    {"false negatives", kFalseNegativeColor},
                                    {"false positives", kFalsePositiveColor}}) {
    coloring.legend.entries.push_back({fmt::format("{}: {}", name, std::ranges::count(coloring.colors, color)), color});
  }
  const std::string title = fmt::format("{}, {}", truth.shot.sample, truth.shot.sensorName);
  return encodePng(drawScan(scan, coloring, 1200, 675, title, false));
}

}  // namespace scanmill
