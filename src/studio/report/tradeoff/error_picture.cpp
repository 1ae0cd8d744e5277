#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "report/tradeoff/report.h"
#include "viewer/color_map.h"
#include "viewer/picture.h"

namespace scanmill {

namespace {

constexpr double kLeast = 1e-3;  // errors below this bound (m) get the same colour
constexpr double kDecades = 3;   // from kLeast to the end of the colours
constexpr Rgb kFalseNegativeColor{255, 70, 70};
constexpr Rgb kFalsePositiveColor{255, 255, 255};
constexpr Rgb kLabelColor{255, 150, 220};

Rgb errorColor(double error) {
  // Fraction of the colour map, at its dark end, that is not used, since its colours can hardly be seen.
  constexpr double kDarkest = 0.15;
  return viridis(kDarkest + (1 - kDarkest) * std::log10(std::max(error, kLeast) / kLeast) / kDecades);
}

}  // namespace

std::string drawErrors(const TrueShot& truth, const Hits& tested) {
  const Hits& real = truth.truth.hits;
  Scan scan;
  scan.rings = real.rings;
  scan.columns = real.columns;
  Coloring coloring;
  std::uint64_t falseNegatives = 0;
  std::uint64_t falsePositives = 0;
  std::uint64_t label = 0;
  const auto add = [&](std::size_t i, double range, const Rgb& color) {
    scan.position.push_back(Vec3f(truth.shot.beams->originOf(i) + truth.shot.beams->direction[i] * range));
    coloring.colors.push_back(color);
  };
  for (std::size_t i = 0; i < real.size(); ++i) {
    if (!real.hit(i) && !tested.hit(i)) continue;
    if (!tested.hit(i)) {
      add(i, truth.truth.range[i], kFalseNegativeColor);
      ++falseNegatives;
    } else if (!real.hit(i)) {
      add(i, double{tested.range[i]}, kFalsePositiveColor);
      ++falsePositives;
    } else if (real.semantic[i] != tested.semantic[i] || real.instance[i] != tested.instance[i]) {
      add(i, truth.truth.range[i], kLabelColor);
      ++label;
    } else {
      add(i, truth.truth.range[i], errorColor(std::abs(double{tested.range[i]} - truth.truth.range[i])));
    }
  }
  coloring.legend.title = "range error";
  for (const auto& [name, error] :
       {std::pair{"1 mm or less", 1e-3}, {"1 cm", 1e-2}, {"10 cm", 0.1}, {"1 m or more", 1.0}}) {
    coloring.legend.entries.push_back({name, errorColor(error)});
  }
  coloring.legend.entries.push_back({fmt::format("other label: {}", label), kLabelColor});
  coloring.legend.entries.push_back({fmt::format("false negatives: {}", falseNegatives), kFalseNegativeColor});
  coloring.legend.entries.push_back({fmt::format("false positives: {}", falsePositives), kFalsePositiveColor});
  const std::string title = fmt::format("{}, {}", truth.shot.sample, truth.shot.sensorName);
  return encodePng(drawScan(scan, coloring, 1200, 675, title, false));
}

}  // namespace scanmill
