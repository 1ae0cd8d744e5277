#pragma once

// The key `corruption` of a pipeline: disturbances for robustness tests of trained networks, in three severities:
//
//   corruption: {fog: heavy}
//
// Each corruption is a file in pipelines/corruptions, or a path to one, with a list of effects for each severity:
//
//   summary: fog, visibility 500, 150 and 50 m
//   light: [weather: {kind: fog, severity: light}]
//   moderate: [...]
//   heavy: [...]

#include <filesystem>
#include <string>
#include <vector>

#include "config/value.h"

namespace scanmill {

// Returns the names of the severities in rising order.
const std::vector<std::string>& severities();

// Returns the list `effects` with the effects of the corruption. If the list names the same effect, the keys of the
// corruption replace those of the list; if it leaves the effect out, draws it at random or has another kind of weather,
// the corruption's effect replaces the list's. All other effects of the corruption are added. The list may be Null, or
// the word `sensor`. Throws InputError.
Value withCorruption(const Value& effects, const Value& corruption);

// Returns the names of the corruptions that come with the program, in alphabetical order.
std::vector<std::string> corruptionNames();

// Returns the summary of one of these corruptions. Throws InputError for another name.
std::string corruptionSummary(const std::string& name);

}  // namespace scanmill
