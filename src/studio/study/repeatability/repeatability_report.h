#pragma once

// The charts of a repeatability study, as SVG. `method` is an index into Repeatability::methods.

#include <cstddef>
#include <string>

#include "study/repeatability/repeatability.h"

namespace scanmill {

// Of the reference level, a line per view: the paper's Figure 10, with and without ICP, and its Figure 13.
std::string repeatabilityRegisteredSvg(const Repeatability& result, std::size_t method);
std::string repeatabilityUnmovedSvg(const Repeatability& result, std::size_t method);
std::string repeatabilityPointsSvg(const Repeatability& result, std::size_t method);
// Fitness after ICP by that before, against the number of points, of all levels.
std::string repeatabilityShareSvg(const Repeatability& result, std::size_t method);

// Of one view: the reference level against each level (the paper's Figure 11), and each level against itself.
std::string repeatabilityLevelsSvg(const Repeatability& result, const RepeatedView& view);
std::string repeatabilityWithinSvg(const Repeatability& result, const RepeatedView& view);

// All methods, of the views with this name.
std::string repeatabilityMethodsSvg(const Repeatability& result, const std::string& view);

// A fitness (m²) in cm², with so many decimals that `like` has three digits.
std::string squareCentimetres(double fitness, double like);

// index.html, self-contained. `date` is that of the measurement.
std::string repeatabilityReport(const Repeatability& result, const std::string& date);

}  // namespace scanmill
