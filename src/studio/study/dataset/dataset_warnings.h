#pragma once

// What is remarkable about a dataset, in plain words.

#include <filesystem>
#include <string>
#include <vector>

#include "study/dataset/dataset_summary.h"

namespace scanmill {

struct DatasetWarning {
  std::string text;                   // one sentence or two, complete in themselves
  std::vector<std::string> places{};  // samples, instances, shards: one line each
  std::string command{};              // for a shell, that shows it
  bool note = false;                  // worth knowing, and no sign of a fault
};

// What could not be read as it should.
struct ReadingFaults {
  std::vector<std::string> shards;    // one line each
  std::vector<std::string> scans;     // that could not be read
  std::vector<std::string> mistaken;  // that disagree with the manifest
};

// `folder` is the dataset's, as commands name it.
std::vector<DatasetWarning> warningsOf(const DatasetSummary& summary, const ReadingFaults& faults,
                                       const std::filesystem::path& folder);

}  // namespace scanmill
