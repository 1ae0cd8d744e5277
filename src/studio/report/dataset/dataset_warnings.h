#pragma once

// Writes warnings about a dataset in plain words.

#include <filesystem>
#include <string>
#include <vector>

#include "report/dataset/dataset_summary.h"

namespace scanmill {

struct DatasetWarning {
  std::string text;                   // one or two sentences that are understandable without context
  std::vector<std::string> places{};  // names of the affected samples, instances or shards
  std::string command{};              // shell command that shows the problem; empty: none
  bool note = false;                  // true: information that is not a sign of a fault
};

// Faults that were found while reading the dataset, one line each.
struct ReadingFaults {
  std::vector<std::string> shards;    // missing or damaged shards
  std::vector<std::string> scans;     // scans that could not be read
  std::vector<std::string> mistaken;  // scans that contradict the manifest
};

// Returns the lines without repetitions. Lines that are equal except for their numbers become one: the names
// "Bauble.001" to "Bauble.050" become "Bauble.001 and 49 alike".
std::vector<std::string> alikeLines(const std::vector<std::string>& lines);

// Returns the warnings. `folder`: path of the dataset as the user gave it.
std::vector<DatasetWarning> warningsOf(const DatasetSummary& summary, const ReadingFaults& faults,
                                       const std::filesystem::path& folder);

}  // namespace scanmill
