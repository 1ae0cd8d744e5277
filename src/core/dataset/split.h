#pragma once

// Assigns sequences to splits. All frames of a sequence go to the same split, because neighbouring frames look alike.

#include <string>
#include <vector>

#include "config/value.h"

namespace scanmill {

// Identifies a sequence: one scene with one seed and one trajectory.
struct SequenceName {
  std::string scene;
  std::uint64_t seed = 0;
  std::string trajectory;
};

// Returns the split of each sequence. `value`: the pipeline's key `splits`; if it is null, all sequences go to "train".
// All sequences with the same seed or trajectory (see `by`) form a group that goes to one split. Groups are
// assigned either by shares that sum to 1, {by: seed, train: 0.8, val: 0.1, test: 0.1}, or by lists, {by: trajectory,
// train: [a, b], val: [c]}.
//
// Shares are matched as closely as undivided groups allow (method of the largest remainder). The split of a group is
// random and depends on `seed`. Throws an InputError with the place in the pipeline for invalid values. If a share
// above 0 gets no group, the error also states the number of groups.
std::vector<std::string> assignSplits(const Value* value, const std::vector<SequenceName>& sequences,
                                      std::uint64_t seed);

}  // namespace scanmill
