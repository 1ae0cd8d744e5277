#pragma once

// What is remarkable about a dataset, in plain words.

#include <filesystem>
#include <string>
#include <vector>

#include "report/dataset/dataset_summary.h"

namespace scanmill {

struct DatasetWarning {
  std::string text;                   // one sentence or two, complete in themselves
  std::vector<std::string> places{};  // the samples, instances or shards that it is about, one line each
  std::string command{};              // a line for a shell that shows it
  bool note = false;                  // it is worth knowing, and no sign of a fault
};

// What could not be read as it should be, one line for each fault.
struct ReadingFaults {
  std::vector<std::string> shards;    // missing or damaged shards
  std::vector<std::string> scans;     // scans that could not be read
  std::vector<std::string> mistaken;  // scans that disagree with the manifest
};

// Writes the warnings. `folder` is the dataset's, as it was named to the command.
std::vector<DatasetWarning> warningsOf(const DatasetSummary& summary, const ReadingFaults& faults,
                                       const std::filesystem::path& folder);

}  // namespace scanmill
