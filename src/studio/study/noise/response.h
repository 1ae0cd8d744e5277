#pragma once

// Finds the response of a sensor: how it turns the power of an echo into the intensity that it reports.
//
// The reflectances of the surfaces in a recording are unknown. Therefore the recording is compared with simulated scans
// of places of the same kind, whose powers are known: the brightest hundredth of the recorded surfaces is taken to be
// as bright as the brightest hundredth of the simulated ones, and so on (histogram specification; Gonzalez and Woods,
// "Digital image processing", 3rd ed., section 3.3.2). Surfaces are cells of kSurfaceCell, whose medians have little
// noise. Simulated cells are weighted so that each band of ranges has the same shares of ground and of everything else
// as in the recording.

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "scan/scan.h"

namespace scanmill {

constexpr double kSurfaceCell = 0.3;  // m, side of the cells

// The quantity from which a sensor computes intensities, as in the key `model` of the effect: the power of the echo, or
// the reflectivity, which is the power corrected for the range.
enum class ResponseModel { Power, Reflectivity };

struct ResponseFit {
  bool bytes = false;  // true: intensities are integers from 0 to 255; false: any numbers
  ResponseModel model = ResponseModel::Power;
  std::vector<std::pair<double, double>> table{};  // value (power or reflectivity) and intensity, both ascending
  // Slope of log(intensity) over log(value) between the quartiles of the surfaces' values. The gain error of the
  // intensity divided by this slope is the gain error of the power.
  double slope = 1;
  double floor = 0;  // power that the sensor does not measure; 1: a white target at 10 m; 0: none was found
  // The receiver's noise: the part of the intensities' standard deviation that the simulated scans do not have, as a
  // fraction of the full scale (255 for bytes, otherwise 1). Includes speckle if the simulated scans have none.
  double noise = 0;
  double step = 0;    // step of the intensities, as a fraction of the full scale; 0: none was found
  double misfit = 0;  // RMS difference of the medians of recorded and simulated surfaces, over kinds of surfaces (band
                      // of ranges, ground or not), as a fraction of the recorded 5 to 95 % span of intensities
  double otherMisfit = 0;                   // `misfit` of the fit with the other ResponseModel
  std::size_t recorded = 0, simulated = 0;  // numbers of surfaces
};

// Fits the response. `recorded`: scans with the column intensity. `simulated`: scans with the column power, in which 1
// is a white target at 10 m. All scans must be in the sensor's frame, with z upwards. Throws InputError if a column is
// missing, or if there are too few surfaces.
ResponseFit fitResponse(const std::vector<Scan>& recorded, const std::vector<Scan>& simulated);

// Returns the YAML text of the effect `intensity`, an item of the key `effects`, with a comment about its origin.
// `diffuse`: value of the effect's key `diffuse` in the pipeline of the simulated scans. `source`: the name of the
// simulated scans.
std::string responseYaml(const ResponseFit& fit, const std::string& diffuse, const std::string& source);

}  // namespace scanmill
