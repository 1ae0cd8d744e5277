#pragma once

// Finds objects whose class is likely to be wrong although all of their points have the same class.

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
  // The class whose size the object has; absent if the object was found because other objects of its class have no ids.
  std::optional<std::uint16_t> like{};
  std::uint64_t alike = 0;  // number of well seen objects that define the size of that class
};

// Finds, first, objects with an id in a class that otherwise has no ids; then well seen objects whose size lies clearly
// outside the sizes of their class and within the sizes of another class. Instances with labels of several classes are
// reported as MixedInstance instead.
std::vector<Anomaly> findAnomalies(const DatasetSummary& summary);

// Returns a shell command that shows the object in the scan with most of its points: "scanmill view FOLDER --sample KEY
// ...".
std::string viewCommand(const std::filesystem::path& folder, const ThingSummary& thing, bool severalSensors);

}  // namespace scanmill
