#pragma once

// The charts of a study's report.

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "charts/chart.h"
#include "study/tradeoff/study.h"

namespace scanmill {

inline constexpr std::size_t kReportRows = 40;  // rows of settings in a chart, at most

// Returns all charts of the report; a chart without data has no points.
std::vector<Chart> studyCharts(const Study& study);
// Names of the charts that are also files: speed against error, error by range and by incidence, encodings, rings.
inline constexpr std::array kStudyFiles{"pareto", "errors_by_range", "errors_by_incidence", "encodings", "rings"};

// Returns the timings by number of rings, each with its name.
std::vector<std::pair<std::string, const RingFit*>> ringFits(const Study& study);

}  // namespace scanmill
