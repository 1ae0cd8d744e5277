#pragma once

// Which sequence goes to which split. Whole sequences only: neighbouring frames must never be parted.

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

// YAML: splits: {by: seed | trajectory, train: 0.8, val: 0.1, test: 0.1}, shares of the groups that sum to 1, or
// explicit lists: {by: seed, train: [1, 2, 3], val: [4]}. All sequences of one group (one seed, or one trajectory)
// share a split. Null gives "train" to all. Shares are met as nearly as whole groups allow (largest remainder), the
// assignment follows from `seed` alone; a share above 0 that gets no group is an InputError that says how many groups
// there are.
std::vector<std::string> assignSplits(const Value* value, const std::vector<SequenceName>& sequences,
                                      std::uint64_t seed);

}  // namespace scanmill
