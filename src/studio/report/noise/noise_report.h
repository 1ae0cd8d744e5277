#pragma once

// The report of the noise that was measured on recorded scans.

#include <string>
#include <string_view>
#include <vector>

#include "charts/chart.h"
#include "study/noise/fit_noise.h"
#include "study/noise/noise_comparison.h"

namespace scanmill {

// The charts of the report that are files of their own, too.
std::vector<Chart> noiseCharts(const NoiseFit& fit, const std::vector<ResidualComparison>& comparison);

// The page index.html, which needs no other file: what was measured, the fitted model, and the recording beside its
// simulation. `sensor` is the sensor's model, `effects` the text of effectsYaml().
std::string noiseReport(const NoiseFit& fit, const std::vector<ResidualComparison>& comparison,
                        const std::string& sensor, const std::string& effects, const std::string& date);

extern const std::string_view kNoiseTemplate;  // noise.html

}  // namespace scanmill
