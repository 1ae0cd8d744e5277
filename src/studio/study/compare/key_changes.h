#pragma once

// Suggests values for the keys of a simulated dataset's pipeline that make its scans more similar to the real ones.

#include <filesystem>
#include <string>
#include <vector>

#include "config/value.h"
#include "study/compare/compare.h"

namespace scanmill {

// Returns the suggested changes. `own`: effects of the simulated sensor, as returned by sensorEffectItems(). Nothing is
// suggested for effects that the sensor lacks, for keys that are missing or not a positive number (0, lists, random
// values), or for figures that differ by less than a tenth.
std::vector<KeyChange> adviceFor(const SetComparison& comparison, const std::vector<Value>& own);

// Returns an argument of --set that applies all advice, such as "effects=[sensor, ring_bias: {gain_sigma: 0.07}]".
// `items`: the effects list of the pipeline file.
std::string assignmentOf(const std::vector<KeyChange>& advice, const std::vector<Value>& items);

// Reads the pipeline of the simulated set, and sets `advice` and `assignment` of the comparison; if there is no advice,
// sets `unadvised` to the reason. `simulated`: folder of the set. `sensor`: name of the compared sensor; empty: the
// first sensor. `pipeline`: path of the pipeline file; empty: search for the file.
void addKeyChanges(SetComparison& comparison, const std::filesystem::path& simulated, const std::string& sensor,
                   const std::filesystem::path& pipeline);

}  // namespace scanmill
