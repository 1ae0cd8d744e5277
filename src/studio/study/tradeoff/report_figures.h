#pragma once

// Figures of a study as a report writes them, and which of its settings stand out.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "study/tradeoff/study.h"

namespace scanmill {

// Errors below this (m) count as none: single precision, in which scans are kept, resolves no more at 100 m.
inline constexpr double kExactRange = 1e-5;

std::string metresText(double metres);      // 0, 46.4 mm, 1.23 m
std::string secondsText(double seconds);    // 350 µs, 2.9 ms, 1.2 s
std::string amountText(double amount);      // 950, 45.3 k, 1.28 M
std::string shareText(double share);        // 98.4 %, 99.9991 %; 100 % and 0 % only of all and of none
std::string factorText(double factor);      // 2.1, 27, 0.35
std::string wordsOf(std::string_view key);  // depth_camera: depth camera
std::string pluralOf(std::uint64_t count, std::string_view what);  // 1 scan, 2 scans
// Of BeamErrors::byPlace: away from edges, at edges.
std::string placeText(const std::string& group);
const GroupErrors* awayFromEdges(const BeamErrors& errors);  // null: nothing is known of edges

// Of the beams those that hit, miss or are labelled wrongly.
double wrongShare(const GroupErrors& errors);
// Of the true hits those that are not hit.
double lostShare(const GroupErrors& errors);
// The range error that 99 % stay below, or 0 where it counts as none; NaN where no beam hits by both.
double rangeP99(const GroupErrors& errors);
// The mean distance from true points to the nearest of the setting's, or 0 where it counts as none; NaN of none.
double nearestMean(const GroupErrors& errors);

double beamsPerSecond(const Study& study, const SettingResult& result);
bool isDefault(const Setting& setting);
// "--set 'method={particle: {refine: none}}'", quoted for a shell.
std::string setArgument(const Setting& setting);

// Indices of settings.
std::vector<std::size_t> measuredSettings(const Study& study);
// Of time and error, the fastest first. From the most exact on, each is faster than the one before by more than times
// differ between two measurements of one thing.
std::vector<std::size_t> rangeFront(const Study& study);        // by rangeP99
std::vector<std::size_t> wrongFront(const Study& study);        // by wrongShare
std::optional<std::size_t> tracingDefault(const Study& study);  // ray tracing with its defaults, if measured
std::vector<std::string> methodsOf(const Study& study);         // in the order they occur
std::vector<std::size_t> shownSettings(const Study& study,
                                       std::size_t most);  // methods' defaults, their fastest, the fronts

// Of charts' palette: of a method the same in every chart of every report.
std::size_t methodColor(const Study& study, const std::string& method);
// Each its own: of each method the first one the method's.
std::vector<std::size_t> settingColors(const Study& study, const std::vector<std::string>& methods);

// All that were measured, or where there are more than `most` the shown ones, method by method.
std::vector<std::size_t> settingsByMethod(const Study& study, std::size_t most);

}  // namespace scanmill
