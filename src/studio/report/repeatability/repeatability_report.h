#pragma once

// The report of a repeatability study. Charts are SVG; `method` is an index into Repeatability::methods.

#include <cstddef>
#include <string>

#include "study/repeatability/repeatability.h"

namespace scanmill {

// Charts of the reference level with a line per view: the fitness with and without ICP (the paper's Figure 10), and the
// number of points (its Figure 13).
std::string repeatabilityRegisteredSvg(const Repeatability& result, std::size_t method);
std::string repeatabilityUnmovedSvg(const Repeatability& result, std::size_t method);
std::string repeatabilityPointsSvg(const Repeatability& result, std::size_t method);
// The fitness after ICP divided by the fitness before, against the number of points, of all levels.
std::string repeatabilityShareSvg(const Repeatability& result, std::size_t method);

// Charts of one view: the reference level against each level (the paper's Figure 11), and each level against itself.
std::string repeatabilityLevelsSvg(const Repeatability& result, const RepeatedView& view);
std::string repeatabilityWithinSvg(const Repeatability& result, const RepeatedView& view);

// All methods beside each other, of the views with this name.
std::string repeatabilityMethodsSvg(const Repeatability& result, const std::string& view);

// A fitness (m²) in cm², with as many decimals as `like` needs for three digits.
std::string squareCentimetres(double fitness, double like);

// The page index.html, which needs no other file. `date` is that of the measurement.
std::string repeatabilityReport(const Repeatability& result, const std::string& date);

}  // namespace scanmill
