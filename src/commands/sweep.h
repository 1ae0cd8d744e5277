#pragma once

#include <string>
#include <vector>

namespace scanmill {

// A dataset of a sweep.
struct SweepSet {
  std::string folder;                  // its name within the sweep's: "preset=os1_128,severity=heavy"
  std::vector<std::string> overrides;  // as --set takes them
};

// The datasets of `--sweep KEY=[A, B, ...]`, given once or several times: one for each combination of values, the last
// key's changing fastest. Throws InputError for what is no list, an empty one, a key that is swept twice, or more than
// 1000 combinations.
std::vector<SweepSet> sweepSets(const std::vector<std::string>& sweeps);

// The sweep over no corruption and all that come with the program, see pipeline/read/corruption.h.
std::string corruptionSweep();

}  // namespace scanmill
