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

inline constexpr std::size_t kReportRows = 40;  // a chart has rows for at most so many settings

// All of them; those without anything to show have no points.
std::vector<Chart> studyCharts(const Study& study);
// The names of those that are files, too: speed against error, error by range and by incidence, encodings, rings.
inline constexpr std::array kStudyFiles{"pareto", "errors_by_range", "errors_by_incidence", "encodings", "rings"};

// What was timed against rings, with its name.
std::vector<std::pair<std::string, const RingFit*>> ringFits(const Study& study);

}  // namespace scanmill
