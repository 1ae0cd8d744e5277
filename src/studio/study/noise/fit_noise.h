#pragma once

// Measures the noise of a real sensor on the flat patches of its recordings, and writes it as effects that a pipeline
// can use.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"
#include "sensors/beams.h"
#include "study/noise/flat_patches.h"
#include "study/noise/recorded_scan.h"
#include "study/noise/ring_errors.h"

namespace scanmill {

// A share lost / of, with its standard error.
struct MeasuredShare {
  std::uint64_t lost = 0;
  std::uint64_t of = 0;
  double error = 0;

  double share() const { return of > 0 ? static_cast<double>(lost) / static_cast<double>(of) : 0; }
};

// The noise on patches of a band of range, incidence or intensity. The step is the sensor's rounding of ranges; sigma
// is the standard deviation of the ranges about a smooth surface.
struct PatchGroup {
  std::string name;  // "7.5-10 m", "60-75 deg"
  double low = 0;    // ends of the band; `high` is infinite if the band is open
  double high = 0;
  double range = 0;  // m, mean
  std::size_t patches = 0;
  std::uint64_t points = 0;  // points in the measured halves of the patches
  double sigma = 0;          // m, without the rounding to the step
  double error = 0;          // m, standard error of sigma, by bootstrap over the patches
  double withStep = 0;       // m, the same deviation, with the rounding
  double planeSigma = 0;     // m, deviation about planes, which includes ring offsets, curvature and motion
  double unevenness = 0;  // spread of the patches' variances over the spread that equal noise would give; 1: no wider
  MeasuredShare dropOut;
  std::string leftOut;  // why the fit does not use the band; empty if it does
};

struct NoiseFit {
  std::vector<std::string> files;  // names without folders
  std::size_t patches = 0;         // patches that the fit uses
  std::uint64_t points = 0;        // points of these patches
  std::uint64_t returns = 0;       // returns of all beams
  std::uint64_t beams = 0;
  double step = 0;                      // m, to which ranges are rounded; 0 if none was found
  double mostIncidence = 0;             // rad
  double sensorReach = 0;               // m, from the beam table
  std::vector<PatchGroup> bands;        // by range, of patches with incidences up to mostIncidence
  std::vector<PatchGroup> incidences;   // by incidence, at all ranges that the fit uses
  std::vector<PatchGroup> intensities;  // by intensity, at all ranges that the fit uses; empty without intensities

  // The model sigma(r) = base + growth * r, by least squares weighted with the bands' errors.
  double base = 0;  // m
  double baseError = 0;
  double growth = 0;  // m per m
  double growthError = 0;
  double chiSquare = 0;
  double freedom = 0;
  double largestMisfit = 0;  // the largest relative difference between a band and the model
  bool linear = true;        // false: the bands themselves are the model
  MeasuredShare dropOut;     // drop-out in the bands that the fit uses
  RingErrors rings;          // errors by ring, from patches at ranges and incidences that the fit uses

  double sigmaAt(double range) const;  // m, from the model
  double measuredUpTo() const;         // m, mean range of the last band that the fit uses
};

struct FitNoiseOptions {
  double mostIncidence = radians(60);  // patches that are seen at a larger incidence are not used
};

// Fits the model to patches of the scans. Throws InputError if the scans hold too few flat patches.
NoiseFit fitNoise(const BeamTable& beams, const std::vector<RecordedScan>& scans, const std::vector<FlatPatch>& patches,
                  const FitNoiseOptions& options = {});

// Returns a line that says up to which range the noise was measured and what the model gives beyond, then a line for
// each farther band that the fit left out. Empty if the sensor reaches no farther than was measured.
std::vector<std::string> beyondMeasured(const NoiseFit& fit);

// Returns the key `effects` of a sensor file, with comments on the origin of the figures. Ends with a newline.
std::string effectsYaml(const NoiseFit& fit, const std::string& date);

}  // namespace scanmill
