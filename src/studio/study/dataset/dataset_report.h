#pragma once

// The report of a dataset: one HTML file that opens without a network.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "study/dataset/dataset_summary.h"
#include "study/dataset/dataset_warnings.h"
#include "viewer/image.h"

namespace scanmill {

struct DatasetReportOptions {
  std::uint64_t seed = 0;       // of the choice of samples
  std::size_t samples = 4;      // that are pictured
  std::size_t mostScans = 400;  // that are read for figures
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;
};

// A scan as the page shows it.
struct PicturedScan {
  std::string title, split;
  std::vector<std::pair<std::string, std::string>> pictures;  // what colours mean, PNG
};

struct DatasetReport {
  std::string folder;  // its name
  Manifest manifest;
  DatasetSummary summary;
  std::vector<std::string> shardFaults;  // as an index into the manifest's shards; empty: none
  bool hashed = false;                   // shards were compared by SHA-256 too
  std::vector<DatasetWarning> warnings;
  std::vector<PicturedScan> pictured;
  std::string view;  // HTML of the scans in 3D
  std::uint64_t seed = 0;
};

// Throws InputError where the manifest cannot be read, and Error where none of the scans can. All else that is wrong is
// a warning.
DatasetReport examineDataset(const std::filesystem::path& folder, const DatasetReportOptions& options);

// The same dataset, under the same name, with the same seed and options gives the same bytes.
std::string datasetPage(const DatasetReport& report);

}  // namespace scanmill
