#pragma once

// Things whose class is likely to be wrong, though every one of their points has it.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "study/dataset/dataset_summary.h"

namespace scanmill {

struct OddThing {
  std::size_t thing = 0;  // index into DatasetSummary::things
  // The class whose size it has, and how many well seen things tell that size; absent where the thing is odd because
  // things of its class have no ids.
  std::optional<std::uint16_t> like{};
  std::uint64_t alike = 0;
};

// A few things of a class that otherwise has no instances, first; then well seen ones whose size lies clearly outside
// their class's and within another's. An instance with labels of several classes is left to MixedInstance.
std::vector<OddThing> oddThings(const DatasetSummary& summary);

// "scanmill view FOLDER --sample KEY ...": a line for a shell that shows the thing where most of it is seen.
std::string viewCommand(const std::filesystem::path& folder, const ThingSummary& thing, bool severalSensors);

}  // namespace scanmill
