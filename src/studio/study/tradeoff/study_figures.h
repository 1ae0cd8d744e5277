#pragma once

// Computes figures from a study's measurements: fractions of beams, and which settings are best.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "study/tradeoff/study.h"

namespace scanmill {

// Range errors below this (m) count as zero: scans are stored in single precision, whose resolution at 100 m is hardly
// finer.
inline constexpr double kExactRange = 1e-5;

// The name of the group in BeamErrors::byEdge with the beams that are not near edges.
inline constexpr std::string_view kAwayFromEdges = "interior";

// Returns the errors of the beams that are not near edges; null if edges are not known.
const GroupErrors* awayFromEdges(const BeamErrors& errors);

// Returns the fraction of all beams that are false negatives, false positives, unresolved or wrongly labelled.
double wrongShare(const GroupErrors& errors);
// Returns the 99th percentile of the range error (m); 0 if it is below kExactRange; NaN if no beam hits both in the
// truth and in the test.
double rangeP99(const GroupErrors& errors);

// Returns how many beams per second the setting traces, without the time for its set-up.
double beamsPerSecond(const Study& study, const SettingResult& result);
// True if the setting gives no options, so that all have their defaults.
bool isDefault(const Setting& setting);

// Returns the indices in Study::settings of the settings that were measured: of one method, or of all if it is empty.
std::vector<std::size_t> measuredSettings(const Study& study, const std::string& method = "");

// Returns the Pareto front of time and an error, such as rangeP99(), as indices in Study::settings, the fastest first.
// If two settings on the front differ in time by less than repeated measurements do, only the more exact one is
// returned.
std::vector<std::size_t> frontOf(const Study& study, double (*error)(const GroupErrors&));

// Returns the index of ray tracing with default options; nothing if it was not measured.
std::optional<std::size_t> tracingDefault(const Study& study);
// Returns the names of the methods, in the order in which their settings occur.
std::vector<std::string> methodsOf(const Study& study);

}  // namespace scanmill
