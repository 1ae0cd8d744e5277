#pragma once

// Finds things whose class is likely to be wrong, although every one of their points has it.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "report/dataset/dataset_summary.h"

namespace scanmill {

struct Anomaly {
  std::size_t thing = 0;  // index into DatasetSummary::things
  // The class whose size the thing has; absent where it is found because other things of its class have no ids.
  std::optional<std::uint16_t> like{};
  std::uint64_t alike = 0;  // how many well seen things tell the size of that class
};

// Finds, first, things with an id of a class that otherwise has none; then well seen things whose size lies clearly
// outside the sizes of their class and within those of another class. Instances with labels of several classes are left
// to MixedInstance.
std::vector<Anomaly> findAnomalies(const DatasetSummary& summary);

// A line for a shell that shows the thing where most of it is seen: "scanmill view FOLDER --sample KEY ...".
std::string viewCommand(const std::filesystem::path& folder, const ThingSummary& thing, bool severalSensors);

}  // namespace scanmill
