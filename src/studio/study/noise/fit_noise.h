#pragma once

// The noise of a real sensor, measured on the flat patches of its recordings, as effects that a pipeline can use.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "base/vec.h"
#include "sensors/beams.h"
#include "study/noise/flat_patches.h"
#include "study/noise/recorded_scan.h"

namespace scanmill {

// A share with its standard error.
struct MeasuredShare {
  std::uint64_t lost = 0;
  std::uint64_t of = 0;
  double error = 0;

  double share() const { return of > 0 ? static_cast<double>(lost) / static_cast<double>(of) : 0; }
};

// Patches that have something in common.
struct PatchGroup {
  std::string name;  // "7.5-10 m", "60-75 deg"
  double low = 0;    // of the range, the incidence or the intensity
  double high = 0;   // infinite: no end
  double range = 0;  // m, mean
  std::size_t patches = 0;
  std::uint64_t points = 0;  // of the measured halves
  double sigma = 0;          // m, without the step
  double error = 0;          // m, standard error of sigma, by bootstrap over the patches
  double withStep = 0;       // m
  double planeSigma = 0;     // m, about planes, without the step: ring offsets, bends and motion included
  double unevenness = 0;     // how much wider the patches' variances spread than those of equal noise: 1 is none
  MeasuredShare dropOut;
  double density = 0;          // returns per m^2, median
  double densityRatio = 0;     // measured / expected by the beam table, median of the patches' own ratios
  double expectedDensity = 0;  // density / ratio: the median of the expected ones is that of another patch
  std::string leftOut;         // why the fit uses none of it; empty: it does
};

struct NoiseFit {
  std::vector<std::string> files;  // names only
  std::size_t patches = 0;         // that the fit uses
  std::uint64_t points = 0;
  std::uint64_t returns = 0;  // of all beams
  std::uint64_t beams = 0;
  double step = 0;                      // m, of the ranges; 0: none
  double mostIncidence = 0;             // rad
  double sensorReach = 0;               // m, by the beam table
  std::vector<PatchGroup> bands;        // by range, up to that incidence
  std::vector<PatchGroup> incidences;   // by incidence, all ranges that the fit uses
  std::vector<PatchGroup> intensities;  // likewise; empty without intensities

  // sigma(r) = base + growth * r, by least squares weighted with the bands' errors.
  double base = 0;  // m
  double baseError = 0;
  double growth = 0;  // m per m
  double growthError = 0;
  double chiSquare = 0;
  double freedom = 0;
  double largestMisfit = 0;  // of a band, relative
  bool linear = true;        // else the bands themselves are the model
  MeasuredShare dropOut;     // of the bands that the fit uses

  double sigmaAt(double range) const;  // m, of the model
  double measuredUpTo() const;         // m, mean range of the last band that the fit uses
};

struct FitNoiseOptions {
  double mostIncidence = radians(60);  // of the patches that the fit uses
};

// Throws InputError where the scans hold too few flat patches.
NoiseFit fitNoise(const BeamTable& beams, const std::vector<RecordedScan>& scans, const std::vector<FlatPatch>& patches,
                  const FitNoiseOptions& options = {});

// What the model says of ranges beyond the measured ones, where the sensor reaches farther; else empty. A sentence, of
// a line or two.
std::vector<std::string> beyondMeasured(const NoiseFit& fit);

// `effects:` of a sensor file, with where the figures come from as comments. Ends with a newline.
std::string effectsYaml(const NoiseFit& fit, const std::string& date);

}  // namespace scanmill
