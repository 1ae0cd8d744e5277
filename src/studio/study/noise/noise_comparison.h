#pragma once

// Compares a recording with a simulation of its own patches: the planes that were found, seen by the same beams, with
// the fitted effects.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "sensors/beams.h"
#include "study/noise/fit_noise.h"
#include "study/noise/plane_motion.h"

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

// The fitness (mean squared distance to the nearest point, m^2) of the patches' points of two scans, one scan moved
// onto the other. Planes give the motion, since points would be moved until their own fitness is best. Where a motion
// did not converge, its fitness is absent.
struct FitnessComparison {
  std::string pair;  // "a.pcd on b.pcd"
  PlaneMotion recordedMotion;
  PlaneMotion simulatedMotion;  // from the planes as measured in the simulation: it differs by their noise alone
  std::optional<double> recorded;
  std::optional<double> simulated;
  // The fitness of a simulation without effects, moved as the recording: what the pattern of the beams alone makes.
  std::optional<double> exact;
};

struct NoiseComparison {
  std::vector<ResidualComparison> residuals;
  std::vector<FitnessComparison> fitness;
};

// Compares on the patches at ranges that the fit uses. `effects` is a list as in a sensor file, see effectsYaml().
NoiseComparison compareNoise(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                             const std::vector<FlatPatch>& patches, const NoiseFit& fit, const std::string& effects);

}  // namespace scanmill
