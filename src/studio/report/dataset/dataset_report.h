#pragma once

// The report of a dataset: one HTML file that opens without a network.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "report/dataset/dataset_summary.h"
#include "report/dataset/dataset_warnings.h"
#include "report/dataset/object_counts.h"
#include "viewer/image.h"

namespace scanmill {

struct DatasetReportOptions {
  std::uint64_t seed = 0;       // decides which samples are pictured
  std::size_t samples = 4;      // so many samples are pictured
  std::size_t mostScans = 400;  // at most so many scans are read for figures
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;
};

// A scan as the page shows it.
struct PicturedScan {
  std::string title, split;
  std::vector<std::pair<std::string, std::string>> pictures;  // each: what the colours mean, and the bytes of the PNG
};

struct DatasetReport {
  std::string folder;  // the name of the dataset's folder
  std::string path;    // the folder as it was named
  Manifest manifest;
  DatasetSummary summary;
  std::vector<std::string> shardFaults;  // one per shard of the manifest; empty where the shard is sound
  bool hashed = false;                   // shards were compared by SHA-256, too
  std::vector<DatasetWarning> warnings;
  std::vector<PicturedScan> pictured;
  std::vector<PicturedScan> reasonImages;  // of the same scans, as far as they have them
  ObjectCounts objects;                    // of the samples whose scans were read for figures
  std::string view;                        // the scans in 3D, as scanView() writes them
  std::uint64_t seed = 0;
};

// Reads a dataset and finds out what its report says. Throws InputError where the manifest cannot be read, and Error
// where none of the scans can be. Everything else that is wrong is a warning.
DatasetReport examineDataset(const std::filesystem::path& folder, const DatasetReportOptions& options);

// The report as one HTML file. The same dataset, under the same name, with the same seed and options gives the same
// bytes.
std::string datasetPage(const DatasetReport& report);

}  // namespace scanmill
