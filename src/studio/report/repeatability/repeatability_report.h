#pragma once

// The report of a repeatability study. `method` is an index into Repeatability::methods.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "charts/chart.h"
#include "study/repeatability/repeatability.h"

namespace scanmill {

// Returns charts of the reference level with a line per view: the fitness with and without ICP (the paper's Figure 10),
// and the number of points (its Figure 13).
std::vector<Chart> repeatabilityCharts(const Repeatability& result, std::size_t method);
// Returns charts of one view: the reference level against each level (the paper's Figure 11), and each level against
// itself.
std::vector<Chart> repeatabilityViewCharts(const Repeatability& result, const RepeatedView& view);
// Returns a chart that compares all methods on the views with this name.
Chart repeatabilityMethods(const Repeatability& result, const std::string& view);

// Returns the page index.html, which needs no other file. `date` is the date of the measurement.
std::string repeatabilityReport(const Repeatability& result, const std::string& date);

extern const std::string_view kRepeatabilityTemplate;  // repeatability.html

}  // namespace scanmill
