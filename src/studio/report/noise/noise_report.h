#pragma once

// The report of the noise that was measured on recorded scans.

#include <string>
#include <vector>

#include "study/noise/fit_noise.h"
#include "study/noise/noise_comparison.h"

namespace scanmill {

// A chart of the report, which is a file of its own, too.
struct NoiseChart {
  std::string name;  // "range_noise"
  std::string svg;
};
std::vector<NoiseChart> noiseCharts(const NoiseFit& fit, const NoiseComparison& comparison);

// The page index.html, which needs no other file: what was measured, the fitted model, and the recording beside its
// simulation. `sensor` is the sensor's model, `effects` the text of effectsYaml().
std::string noiseReport(const NoiseFit& fit, const NoiseComparison& comparison, const std::string& sensor,
                        const std::string& effects, const std::string& date);

}  // namespace scanmill
