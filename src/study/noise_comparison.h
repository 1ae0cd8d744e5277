#pragma once

// What was recorded, beside the same patches simulated: the planes that were found, seen by the same beams, with the
// fitted effects.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "sensors/beams.h"
#include "study/fit_noise.h"

namespace scanmill {

// One of the two, or of steep and grazing views.
struct ResidualSpread {
  std::vector<double> residuals;  // m, about the lines: see FlatPatch::residuals
  double deviation = 0;           // m, that most patches share, the step included
  double planeDeviation = 0;      // likewise about planes
};

struct ResidualComparison {
  std::string name;  // "up to 60 deg"
  std::size_t patches = 0;
  ResidualSpread recorded;
  ResidualSpread simulated;
};

// Clouds of two scans' patches, one registered onto the other: mean squared distance (m^2) to the nearest point.
struct FitnessComparison {
  std::string pair;  // "a.pcd on b.pcd"
  std::optional<double> recorded;
  std::optional<double> simulated;
  std::optional<double> exact;  // simulated without effects: what the beams' pattern alone makes
  double moved = 0;             // m, of the recorded pair
};

struct NoiseComparison {
  std::vector<ResidualComparison> residuals;
  std::vector<FitnessComparison> fitness;
};

// On patches at ranges that the fit uses. `effects` is a list as in a sensor file, see effectsYaml().
NoiseComparison compareNoise(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                             const std::vector<FlatPatch>& patches, const NoiseFit& fit, const std::string& effects);

}  // namespace scanmill
