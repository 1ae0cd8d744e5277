#pragma once

// Makes the charts of a trade-off study's report.

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "charts/chart.h"
#include "study/tradeoff/study.h"

namespace scanmill {

inline constexpr std::size_t kReportRows = 40;  // maximum number of settings in a chart with one row per setting

// Returns all charts of the report. If there are no data for a chart, it has no points.
std::vector<Chart> studyCharts(const Study& study);
// Names of the charts that are also written as files: speed against error, errors by range and by incidence, encodings,
// and time by number of rings.
inline constexpr std::array kStudyFiles{"pareto", "errors_by_range", "errors_by_incidence", "encodings", "rings"};

// Returns the study's models of time by number of rings, each with a name for the legend.
std::vector<std::pair<std::string, const RingFit*>> ringFits(const Study& study);

}  // namespace scanmill
