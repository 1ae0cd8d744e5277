#pragma once

#include <string>
#include <vector>

#include "study/noise/fit_noise.h"
#include "study/noise/noise_comparison.h"

namespace scanmill {

// The charts of the report, each a file of its own too.
struct NoiseChart {
  std::string name;  // "range_noise"
  std::string svg;
};
std::vector<NoiseChart> noiseCharts(const NoiseFit& fit, const NoiseComparison& comparison);

// index.html, self-contained: what was measured, the fitted model, and the recording beside its simulation. `effects`
// is the text of effectsYaml().
std::string noiseReport(const NoiseFit& fit, const NoiseComparison& comparison, const std::string& sensor,
                        const std::string& effects, const std::string& date);

}  // namespace scanmill
