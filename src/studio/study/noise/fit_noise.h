#pragma once

// Measures a real sensor's noise on flat patches in its recordings, and writes the noise as effects for a pipeline.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "evaluate/spread.h"
#include "sensors/beams.h"
#include "study/noise/flat_patches.h"

namespace scanmill {

// One error per ring and the spread of these errors over the rings. Only differences between neighbouring rings can be
// measured, since the plane fitted to each patch absorbs errors that are common to its rings or linear over them.
struct RingSpread {
  std::vector<double> ofRing;  // error of each ring; 0 if no patch contains the ring
  double sigma = 0;            // standard deviation between rings, after removing the part due to noise
  // Correlation between the errors measured on the odd patches and those measured on the even patches. Near 1: the
  // errors belong to the sensor. Near 0: they are noise.
  double agreement = 0;
  std::size_t rings = 0;  // number of rings that both the odd and the even patches contain
};

// The constant errors of a sensor's lasers, measured on flat patches.
struct RingErrors {
  RingSpread range;  // errors of the range (m)
  RingSpread
      elevation;    // errors of the elevation (rad); empty if the patches do not tell them from errors of the range
  RingSpread gain;  // errors of the gain (natural logarithm); empty if scans have no intensities
};

// Returns the rings' errors, from a least-squares fit to all patches together. The model of the range differences is a
// plane per patch plus, for each ring, an offset and an error of the elevation, which moves the range as far as the
// plane is inclined to the beam: hardly on walls, much on the ground. If upright or level patches are few, all errors
// count as offsets. The model of the intensities' logarithms is, per patch, a constant and a slope over the rings, plus
// a gain per ring. If errors are much larger than the noise, they are underestimated: only patches with small
// differences then count as flat.
RingErrors fitRingErrors(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                         const std::vector<const FlatPatch*>& patches);

// Least RingSpread::agreement for which errors are attributed to the sensor.
constexpr double kOwnErrors = 0.5;

// The fraction of beams whose returns are lost, with its standard error.
struct MeasuredShare {
  std::uint64_t lost = 0, beams = 0;
  double error = 0;

  double share() const { return shareOf(lost, beams); }
};

// The noise on all patches in a band of ranges. "Step" means the distance to which the sensor rounds ranges. Sigma is
// the standard deviation of the ranges from a smooth surface.
struct PatchGroup {
  std::string name;  // the band's values, such as "7.5-10 m"
  double high = 0;   // upper end of the band (m); infinite for the last band
  double range = 0;  // mean range (m)
  std::size_t patches = 0;
  std::uint64_t points = 0;  // points in the measured halves of the patches
  double sigma = 0;          // standard deviation of the ranges (m), after removing the effect of the step
  double error = 0;          // standard error of sigma (m), by bootstrap over the patches
  double withStep = 0;       // standard deviation of the ranges, including the effect of rounding to the step (m)
  double planeSigma = 0;     // like sigma, but relative to planes (m): includes ring offsets, curvature and motion
  double unevenness = 0;     // spread of the patches' variances / spread for patches of equal noise
  MeasuredShare dropOut{};
  std::string leftOut{};  // why the fit does not use the band; empty: the fit uses it
};

struct NoiseFit {
  std::vector<std::string> files;  // file names without folders
  std::size_t patches = 0;         // number of patches that the fit uses
  std::uint64_t points = 0;        // number of points in the patches that the fit uses
  std::uint64_t returns = 0;       // number of returns of all beams
  std::uint64_t beams = 0;
  double step = 0;                // step to which the sensor rounds ranges (m); 0 if none was found
  double sensorReach = 0;         // maximum range in the beam table (m)
  std::vector<PatchGroup> bands;  // bands of range; only patches with incidences up to kMostIncidenceDegrees

  // The model sigma(r) = base + growth * r, fitted by least squares with the weights 1 / (the band's error)^2.
  double base = 0;  // sigma at range 0 (m)
  double baseError = 0;
  double growth = 0;  // increase of sigma with range (m per m)
  double growthError = 0;
  double chiSquare = 0, freedom = 0;
  double largestMisfit = 0;  // largest relative difference between a band's sigma and the fitted line
  bool linear = true;        // false: a line does not fit; sigma is given per band instead
  MeasuredShare dropOut;     // lost returns in the bands that the fit uses
  RingErrors rings;          // errors of rings, from patches with ranges and incidences that the fit uses

  std::vector<const PatchGroup*> usedBands() const;  // returns the bands of range that the fit uses
};

// Measures the noise on patches of the scans and fits the model. `patches`: the result of findFlatPatches(). Throws
// InputError if the scans contain too few flat patches.
NoiseFit fitNoise(const BeamTable& beams, const std::vector<RecordedScan>& scans,
                  const std::vector<FlatPatch>& patches);

// Returns a line that states up to which range the noise was measured and how the model continues at larger ranges,
// then a line for each band at larger ranges that has enough patches, but that the fit did not use. Returns nothing if
// the noise was measured up to the sensor's maximum range.
std::vector<std::string> beyondMeasured(const NoiseFit& fit);

// Returns the YAML items of the key `effects` for a sensor file, with comments about their origin. Ends with a newline.
std::string effectsYaml(const NoiseFit& fit, const std::string& date);

// Returns the text of a sensor file with new effects. `effects`: lines that start with "effects:". They replace the
// file's effects of the same names; range_noise also replaces dropout, shell and quantize, and intensity
// replaces speckle. Other effects of the file, such as footprint, are kept before the new ones; everything else,
// including comments, is unchanged. If the file has no effects, the new ones are appended. `file`: name of the file in
// messages. Throws InputError if the text is not a sensor file, or is written in flow style ({...}), in which keys do
// not have separate lines.
std::string withEffects(const std::string& text, const std::string& file, const std::string& effects);

}  // namespace scanmill
