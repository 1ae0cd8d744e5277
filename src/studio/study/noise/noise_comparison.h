#pragma once

// Compares a recording with a simulation of its own patches: the planes that were found, seen by the same beams, with
// the fitted effects.

#include <cstddef>
#include <string>
#include <vector>

#include "sensors/beams.h"
#include "study/noise/fit_noise.h"

namespace scanmill {

// How the ranges of some patches scatter, in the recording or in the simulation.
struct ResidualSpread {
  std::vector<double> residuals;  // m, about the lines: see FlatPatch::residuals
  double deviation = 0;           // m, the one that most patches share; the rounding of ranges is included
  double planeDeviation = 0;      // m, the same about planes
};

// The two beside each other, of steep or of grazing views.
struct ResidualComparison {
  std::string name;  // "up to 60 deg"
  std::size_t patches = 0;
  ResidualSpread recorded;
  ResidualSpread simulated;
};

// Compares on the patches at ranges that the fit uses. `effects` is a list as in a sensor file, see effectsYaml().
std::vector<ResidualComparison> compareNoise(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                                             const std::vector<FlatPatch>& patches, const NoiseFit& fit,
                                             const std::string& effects);

}  // namespace scanmill
