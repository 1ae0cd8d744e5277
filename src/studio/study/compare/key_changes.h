#pragma once

// Suggests values for a simulated dataset's pipeline that bring it nearer to the other set.

#include <filesystem>
#include <string>
#include <vector>

#include "config/value.h"
#include "study/compare/compare.h"

namespace scanmill {

// Returns the advice. `own`: the effects of the simulated sensor, as sensorEffectItems() gives them. There is no advice
// on effects that the sensor lacks, on keys that are lists or random, or for figures that differ by less than a tenth.
std::vector<KeyChange> adviceFor(const SetComparison& comparison, const std::vector<Value>& own);

// Returns an argument of --set that applies all of the advice: "effects=[sensor, ring_bias: {gain_sigma: 0.07}]".
// `items`: the list of effects as the pipeline's file has it.
std::string assignmentOf(const std::vector<KeyChange>& advice, const std::vector<Value>& items);

// Fills the comparison's `advice` and `assignment` from the pipeline of the simulated set, or `unadvised` with the
// reason why there is none. `simulated`: the folder of the set; `sensor`: the compared sensor, empty: the first;
// `pipeline`: the path of the pipeline's file, empty: search for it.
void addKeyChanges(SetComparison& comparison, const std::filesystem::path& simulated, const std::string& sensor,
                   const std::filesystem::path& pipeline);

}  // namespace scanmill
