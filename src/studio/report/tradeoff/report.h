#pragma once

// Writes the report of a trade-off study.

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "charts/chart.h"
#include "evaluate/beam_errors.h"
#include "scan/hits.h"
#include "study/tradeoff/study.h"

namespace scanmill {

// Returns the HTML page index.html with charts, tables and pictures. It needs no other file and no network. `folder`:
// the folder of the report, as given on the command line that the page shows.
std::string studyReport(const Study& study, const std::string& folder);

// Returns the command-line argument that selects a setting, quoted for a shell, such as "--set 'method={particle:
// {refine: none}}'".
std::string setArgument(const Setting& setting);

extern const std::string_view kTradeoffTemplate;  // contents of tradeoff.html

// Draws the true points, coloured by the range error of the tested method. The colour map viridis shows errors from 1
// mm to 1 m on a logarithmic scale. False negatives, false positives (drawn at the tested hit) and beams with a wrong
// label have separate colours. Returns the contents of a PNG file.
std::string drawErrors(const TrueShot& truth, const Hits& tested);

// Returns all charts of the report. If there are no data for a chart, it has no points.
std::vector<Chart> studyCharts(const Study& study);
// Names of the charts that are also written as files: speed against error, errors by range and by incidence, encodings.
inline constexpr std::array kStudyFiles{"pareto", "errors_by_range", "errors_by_incidence", "encodings"};

using GroupsOfErrors = std::vector<ErrorGroup> BeamErrors::*;
// Returns the names of the groups with beams in any of the settings (indices in Study::settings), in the groups' order.
std::vector<std::string> groupNames(const Study& study, const std::vector<std::size_t>& settings,
                                    GroupsOfErrors groups);

// Returns the first `most` noteworthy settings, as indices in Study::settings: first each method with its defaults,
// then the fastest setting of each method, then the settings on the Pareto fronts (see frontOf()).
std::vector<std::size_t> shownSettings(const Study& study, std::size_t most);

// Returns the index of a method's colour in the charts' palette. All charts of a report use this colour for the method.
std::size_t methodColor(const std::string& method);
// Returns a colour (index in the palette) for each setting; the colours differ as long as the palette has enough. The
// first setting of each method gets the method's colour. `settingMethods`: the method of each setting.
std::vector<std::size_t> settingColors(const std::vector<std::string>& settingMethods);

}  // namespace scanmill
