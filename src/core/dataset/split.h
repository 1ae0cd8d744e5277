#pragma once

// Decides which sequence goes to which split. Sequences stay whole, since neighbouring frames look alike and must not
// lie in different splits.

#include <string>
#include <vector>

#include "config/value.h"

namespace scanmill {

// A sequence is one scene with one seed and one trajectory.
struct SequenceName {
  std::string scene;
  std::uint64_t seed = 0;
  std::string trajectory;
};

// Returns the split of each sequence. `value` is the pipeline's key `splits`; where it is null, all sequences go to
// "train". The sequences of one seed, or of one trajectory, are a group and share a split. Groups are given by shares
// that sum to 1, {by: seed, train: 0.8, val: 0.1, test: 0.1}, or by lists, {by: trajectory, train: [a, b], val: [c]}.
//
// Shares are met as nearly as whole groups allow (method of the largest remainder), and which group goes where follows
// from `seed` alone. Throws InputError with the place; also for a share above 0 that gets no group, with the number of
// groups that there are.
std::vector<std::string> assignSplits(const Value* value, const std::vector<SequenceName>& sequences,
                                      std::uint64_t seed);

}  // namespace scanmill
