#pragma once

// Which values of a simulated dataset's pipeline to try, so that it comes nearer to the other set.

#include <filesystem>
#include <string>
#include <vector>

#include "config/value.h"
#include "study/compare/compare.h"

namespace scanmill {

// `own`: the effects that the simulated sensor has, as sensorEffectItems() gives them. Of effects that it lacks, of
// keys that are lists or drawn at random, and of figures that differ by less than a tenth, nothing is said.
std::vector<KeyChange> adviceFor(const SetComparison& comparison, const std::vector<Value>& own);

// An argument of --set that follows all of the advice: "effects=[sensor, ring_bias: {gain_sigma: 0.07}]". `items`: the
// pipeline's list as its file has it.
std::string assignmentOf(const std::vector<KeyChange>& advice, const std::vector<Value>& items);

// Fills the comparison's `advice` and `assignment` by the pipeline of the simulated set, or `unadvised` by why not.
// `simulated`: its folder; `sensor`: the one that was compared, empty: the first; `pipeline`: where its file lies,
// empty: it is looked for.
void addKeyChanges(SetComparison& comparison, const std::filesystem::path& simulated, const std::string& sensor,
                   const std::filesystem::path& pipeline);

}  // namespace scanmill
