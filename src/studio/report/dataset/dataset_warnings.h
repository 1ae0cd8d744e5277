#pragma once

// Writes warnings about a dataset, in plain words.

#include <filesystem>
#include <string>
#include <vector>

#include "report/dataset/dataset_summary.h"

namespace scanmill {

struct DatasetWarning {
  std::string text;                   // one or two sentences that need no context
  std::vector<std::string> places{};  // the samples, instances or shards concerned, one line each
  std::string command{};              // a shell command that shows it
  bool note = false;                  // worth knowing, but not a sign of a fault
};

// Faults met while reading the dataset, one line each.
struct ReadingFaults {
  std::vector<std::string> shards;    // missing or damaged shards
  std::vector<std::string> scans;     // scans that could not be read
  std::vector<std::string> mistaken;  // scans that disagree with the manifest
};

// Writes the warnings. `folder` is the dataset's folder as given on the command line.
std::vector<DatasetWarning> warningsOf(const DatasetSummary& summary, const ReadingFaults& faults,
                                       const std::filesystem::path& folder);

}  // namespace scanmill
