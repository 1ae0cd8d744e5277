#pragma once

#include <string>

#include "study/fit_noise.h"
#include "study/noise_comparison.h"

namespace scanmill {

// index.html, self-contained: what was measured, the fitted model, and the recording beside its simulation. `effects`
// is the text of effectsYaml().
std::string noiseReport(const NoiseFit& fit, const NoiseComparison& comparison, const std::string& sensor,
                        const std::string& effects, const std::string& date);

}  // namespace scanmill
