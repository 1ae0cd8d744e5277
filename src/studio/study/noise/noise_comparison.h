#pragma once

// Compares recorded scans with simulated ones. The simulation uses the same beams, the planes of the flat patches that
// were found in the recording, and the fitted effects.

#include <cstddef>
#include <string>
#include <vector>

#include "sensors/beams.h"
#include "study/noise/fit_noise.h"

namespace scanmill {

// The deviations of ranges on the patches, in the recording or in the simulation.
struct ResidualSpread {
  std::vector<double> residuals;  // deviations from lines (m), see FlatPatch::residuals
  double deviation = 0;       // typical standard deviation (m), see commonDeviation(); includes the rounding of ranges
  double planeDeviation = 0;  // typical standard deviation of the ranges from the patches' planes (m)
};

// Recorded and simulated patches, either at steep or at grazing incidence.
struct ResidualComparison {
  std::string name;  // the range of incidence angles, such as "up to 60 deg"
  std::size_t patches = 0;
  ResidualSpread recorded;
  ResidualSpread simulated;
};

// Compares the recorded deviations on the patches with deviations that `effects` simulates. Returns an entry for steep
// incidence and one for grazing incidence; an entry without patches is omitted. Only ranges that the fit uses are
// compared.
// `effects`: YAML text with the key `effects`, see effectsYaml().
std::vector<ResidualComparison> compareNoise(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                                             const std::vector<FlatPatch>& patches, const NoiseFit& fit,
                                             const std::string& effects);

}  // namespace scanmill
