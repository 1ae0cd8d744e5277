#pragma once

// The report on the noise measured in recorded scans.

#include <string>
#include <string_view>
#include <vector>

#include "charts/chart.h"
#include "study/noise/fit_noise.h"
#include "study/noise/noise_comparison.h"

namespace scanmill {

// Returns the charts of the report that are also written as separate files.
std::vector<Chart> noiseCharts(const NoiseFit& fit, const std::vector<ResidualComparison>& comparison);

// Returns the page index.html, which needs no other file: the measurements, the fitted model, and a comparison of the
// recording with its simulation. `sensor` is the sensor's model, `effects` the text of effectsYaml().
std::string noiseReport(const NoiseFit& fit, const std::vector<ResidualComparison>& comparison,
                        const std::string& sensor, const std::string& effects, const std::string& date);

extern const std::string_view kNoiseTemplate;  // noise.html

}  // namespace scanmill
