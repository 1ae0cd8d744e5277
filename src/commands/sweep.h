#pragma once

#include <string>
#include <vector>

namespace scanmill {

// One dataset of a sweep.
struct SweepSet {
  std::string folder;  // folder of the dataset in the sweep's folder, such as "preset=os1_128,severity=heavy"
  std::vector<std::string> overrides;  // overrides as arguments of --set
};

// Returns the datasets of `--sweep KEY=[A, B, ...]`, given once or several times: one for each combination of values,
// where the values of the last key change fastest. Throws InputError for a value that is not a list, an empty list, a
// key that is swept twice, or more than 1000 combinations.
std::vector<SweepSet> sweepSets(const std::vector<std::string>& sweeps);

// Returns the --sweep argument for a dataset without corruption and a dataset for each corruption and severity.
std::string corruptionSweep();

}  // namespace scanmill
