#pragma once

// What was recorded, beside the same patches simulated: the planes that were found, seen by the same beams, with the
// fitted effects.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "sensors/beams.h"
#include "study/noise/fit_noise.h"
#include "study/noise/plane_motion.h"

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

// Clouds of two scans' patches, one moved onto the other by their planes and not by the points, whose fitness is
// what is asked: mean squared distance (m^2) to the nearest point. A motion that did not converge leaves its fitness
// out.
struct FitnessComparison {
  std::string pair;  // "a.pcd on b.pcd"
  PlaneMotion recordedMotion;
  PlaneMotion simulatedMotion;  // the planes measured again in the simulation: the same, but for its noise
  std::optional<double> recorded;
  std::optional<double> simulated;
  std::optional<double> exact;  // without effects, moved as recorded: what the beams' pattern alone makes
};

struct NoiseComparison {
  std::vector<ResidualComparison> residuals;
  std::vector<FitnessComparison> fitness;
};

// On patches at ranges that the fit uses. `effects` is a list as in a sensor file, see effectsYaml().
NoiseComparison compareNoise(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                             const std::vector<FlatPatch>& patches, const NoiseFit& fit, const std::string& effects);

}  // namespace scanmill
