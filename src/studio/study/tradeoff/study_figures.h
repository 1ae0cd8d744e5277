#pragma once

// Derives figures from a study's measurements: shares of beams, and the settings that stand out.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "study/tradeoff/study.h"

namespace scanmill {

// Range errors below this (m) count as none: scans are stored in single precision, whose resolution at 100 m is no
// finer.
inline constexpr double kExactRange = 1e-5;

// The name of the beams away from edges among BeamErrors::byPlace.
inline constexpr std::string_view kAwayFromEdges = "interior";

// Returns the errors of the beams away from edges; null if edges are unknown.
const GroupErrors* awayFromEdges(const BeamErrors& errors);

// Returns the share of all beams that are false negatives, false positives, unresolved or labelled wrongly.
double wrongShare(const GroupErrors& errors);
// Returns the share of false negatives among the beams that hit something in truth.
double falseNegativeShare(const GroupErrors& errors);
// Returns the 99th percentile of the range error (m), or 0 if it counts as none; NaN if no beam hits in both scans.
double rangeP99(const GroupErrors& errors);
// Returns the mean distance (m) from true points to the nearest points of the setting, or 0 if it counts as none; NaN
// if there are no points.
double nearestMean(const GroupErrors& errors);

// Returns how many beams a second the setting traces, without its set-up.
double beamsPerSecond(const Study& study, const SettingResult& result);
// True if the setting is its method with all defaults.
bool isDefault(const Setting& setting);

// Returns the indices into Study::settings of the measured settings.
std::vector<std::size_t> measuredSettings(const Study& study);

// Return indices into Study::settings of the Pareto front of time and an error, the fastest first. Going from the most
// exact setting to the fastest, each is faster than the one before by more than repeated measurements differ.
std::vector<std::size_t> rangeFront(const Study& study);  // the error is rangeP99()
std::vector<std::size_t> wrongFront(const Study& study);  // the error is wrongShare()

// Returns the index of ray tracing with its defaults; absent if it was not measured.
std::optional<std::size_t> tracingDefault(const Study& study);
// Returns the names of the methods, in the order of the settings.
std::vector<std::string> methodsOf(const Study& study);

}  // namespace scanmill
