#pragma once

// Writes the report on the noise that was measured in recorded scans.

#include <string>
#include <string_view>
#include <vector>

#include "charts/chart.h"
#include "study/noise/fit_noise.h"
#include "study/noise/noise_comparison.h"

namespace scanmill {

// Returns those charts of the report that are also written as separate files.
std::vector<Chart> noiseCharts(const NoiseFit& fit, const std::vector<ResidualComparison>& comparison);

// Returns the HTML page index.html, which needs no other file: the measurements, the fitted model, and a comparison of
// the recording with its simulation. `sensor`: name of the sensor's model. `effects`: the result of effectsYaml().
std::string noiseReport(const NoiseFit& fit, const std::vector<ResidualComparison>& comparison,
                        const std::string& sensor, const std::string& effects, const std::string& date);

extern const std::string_view kNoiseTemplate;  // contents of noise.html

}  // namespace scanmill
