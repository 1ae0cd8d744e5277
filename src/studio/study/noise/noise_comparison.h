#pragma once

// Compares a recording with a simulation of its own patches: the same beams, the planes that were found, and the fitted
// effects.

#include <cstddef>
#include <string>
#include <vector>

#include "sensors/beams.h"
#include "study/noise/fit_noise.h"

namespace scanmill {

// The scatter of the ranges of some patches, in the recording or in the simulation.
struct ResidualSpread {
  std::vector<double> residuals;  // m, about the lines: see FlatPatch::residuals
  double deviation = 0;  // m, the deviation that most patches share (commonDeviation()), with the rounding of ranges
  double planeDeviation = 0;  // m, the same about planes
};

// Recorded and simulated patches side by side, seen at either steep or grazing incidence.
struct ResidualComparison {
  std::string name;  // "up to 60 deg"
  std::size_t patches = 0;
  ResidualSpread recorded;
  ResidualSpread simulated;
};

// Compares the patches at ranges that the fit uses. `effects` is a list as in a sensor file, see effectsYaml().
std::vector<ResidualComparison> compareNoise(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                                             const std::vector<FlatPatch>& patches, const NoiseFit& fit,
                                             const std::string& effects);

}  // namespace scanmill
