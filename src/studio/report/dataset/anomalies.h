#pragma once

// Finds objects whose class is probably wrong, although all points of the object have the same class.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "report/dataset/dataset_summary.h"

namespace scanmill {

struct Anomaly {
  std::size_t thing = 0;  // index in DatasetSummary::things
  // The class whose usual size the object has. Absent if the object was found for another reason: other objects of its
  // class have no ids.
  std::optional<std::uint16_t> like{};
  std::uint64_t alike = 0;  // number of well visible objects from which the usual size of `like` was computed
};

// Returns two kinds of anomalies: first, objects with an id in a class whose other points have no ids; then, well
// visible objects whose size is clearly outside of the usual sizes of their class but within those of another class.
// Instances with points of several classes are not returned; they are reported as MixedInstance.
std::vector<Anomaly> findAnomalies(const DatasetSummary& summary);

// Returns a shell command that shows the object in the scan with most of its points, such as "scanmill view FOLDER
// --sample KEY ...". `severalSensors`: the dataset has several sensors, so the command names one.
std::string viewCommand(const std::filesystem::path& folder, const ThingSummary& thing, bool severalSensors);

}  // namespace scanmill
