#pragma once

// The key `corruption` of a pipeline: what robustness tests put before a trained network, in three severities:
//
//   corruption: {fog: heavy}
//
// Each is a file in pipelines/corruptions, or a path to one, with a list of effects for each severity:
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

// In rising order.
const std::vector<std::string>& severities();

// The list `effects` with what the corruption does: an effect that the list names has the corruption's keys in place of
// its own, or is the corruption's where it was left out, drawn, or another kind of weather; any other is added. The
// list may be Null, or the word `sensor`. Throws InputError.
Value withCorruption(const Value& effects, const Value& corruption);

// Of those that come with the program, in order.
std::vector<std::string> corruptionNames();

// What a corruption is, in words. Throws InputError where it is none of these.
std::string corruptionSummary(const std::string& name);

}  // namespace scanmill
