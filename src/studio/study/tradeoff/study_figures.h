#pragma once

// What follows from the figures of a study: shares of beams, and which of its settings stand out.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "study/tradeoff/study.h"

namespace scanmill {

// Range errors below this (m) count as none: single precision, in which scans are kept, resolves no more at 100 m.
inline constexpr double kExactRange = 1e-5;

// The name of the beams away from edges among BeamErrors::byPlace.
inline constexpr std::string_view kAwayFromEdges = "interior";

// The errors of the beams away from edges; null where nothing is known of edges.
const GroupErrors* awayFromEdges(const BeamErrors& errors);

// The share of all beams that are false negatives, false positives, unresolved or labelled wrongly.
double wrongShare(const GroupErrors& errors);
// The share of false negatives among the beams that hit something in truth.
double falseNegativeShare(const GroupErrors& errors);
// The range error (m) that 99 % of the beams stay below, or 0 where it counts as none; NaN where no beam hits by both.
double rangeP99(const GroupErrors& errors);
// The mean distance (m) from true points to the nearest of the setting's, or 0 where it counts as none; NaN where there
// are no points.
double nearestMean(const GroupErrors& errors);

// How many beams a second the setting traces, its set-up left out.
double beamsPerSecond(const Study& study, const SettingResult& result);
// Whether the setting is its method with all defaults.
bool isDefault(const Setting& setting);

// Indices into Study::settings of those that were measured.
std::vector<std::size_t> measuredSettings(const Study& study);

// Indices into Study::settings of the Pareto front of time and of an error, the fastest first. From the most exact one
// on, each is faster than the one before by more than two measurements of the same work differ.
std::vector<std::size_t> rangeFront(const Study& study);  // the error is rangeP99()
std::vector<std::size_t> wrongFront(const Study& study);  // the error is wrongShare()

// The index of ray tracing with its defaults; absent where that was not measured.
std::optional<std::size_t> tracingDefault(const Study& study);
// The names of the methods, in the order in which the settings name them.
std::vector<std::string> methodsOf(const Study& study);

}  // namespace scanmill
