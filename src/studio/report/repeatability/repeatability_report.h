#pragma once

// Writes the report of a repeatability study. The parameter `method` is an index in Repeatability::methods.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "charts/chart.h"
#include "study/repeatability/repeatability.h"

namespace scanmill {

// Returns charts of the reference noise level with one line per view: the fitness with and without ICP (Figure 10 of
// the LiDAR-GEIL paper, see study/repeatability/repeatability.h), and the number of points (Figure 13).
std::vector<Chart> repeatabilityCharts(const Repeatability& result, std::size_t method);
// Returns charts of one view: the fitness between the reference noise level and each level (Figure 11 of the paper),
// and between scans of the same level.
std::vector<Chart> repeatabilityViewCharts(const Repeatability& result, const RepeatedView& view);

// Returns the HTML page index.html, which needs no other file. `date`: when the study was run.
std::string repeatabilityReport(const Repeatability& result, const std::string& date);

extern const std::string_view kRepeatabilityTemplate;  // contents of repeatability.html

}  // namespace scanmill
