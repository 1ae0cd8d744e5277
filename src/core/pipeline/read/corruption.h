#pragma once

// The key `corruption` of a pipeline: disturbances for testing the robustness of trained networks. A corruption has
// three severities:
//
//   corruption: {fog: heavy}
//
// A corruption is the name of a file in pipelines/corruptions, or the path of another file. The file has a list of
// effects for each severity:
//
//   summary: fog, visibility 500, 150 and 50 m
//   light: [weather: {kind: fog, severity: light}]
//   moderate: [...]
//   heavy: [...]

#include <string>
#include <vector>

#include "config/value.h"

namespace scanmill {

// Returns the names of the severities in rising order.
const std::vector<std::string>& severities();

// Returns the list `effects` after the corruption is applied to it. An effect of the corruption that is also in the
// list replaces only the keys that the corruption states. It replaces the complete effect if it names a kind of
// weather, or if the list gives `none` or a random choice for the effect. Effects of the corruption that are not in the
// list are appended. `effects` may be Null or the word `sensor`. Throws InputError.
[[nodiscard]] Value withCorruption(const Value& effects, const Value& corruption);

// Returns the names of the corruptions that come with the program, in alphabetical order.
std::vector<std::string> corruptionNames();

// Returns the summary of a corruption in corruptionNames(). Throws InputError for another name.
std::string corruptionSummary(const std::string& name);

}  // namespace scanmill
