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
  std::uint64_t seed = 0;       // seed of the choice of pictured samples
  std::size_t samples = 4;      // number of pictured samples
  std::size_t mostScans = 400;  // number of scans that are read for figures, at most
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;
};

// A scan as the page shows it.
struct PicturedScan {
  std::string title, split;
  std::vector<std::pair<std::string, std::string>> pictures;  // each: meaning of the colours, bytes of the PNG
};

struct DatasetReport {
  std::string folder;  // the name of the dataset's folder
  std::string path;    // as given by the user
  Manifest manifest;
  DatasetSummary summary;
  std::vector<std::string> shardFaults;  // one per shard of the manifest; empty if the shard is sound
  bool hashed = false;                   // the SHA-256 of shards was compared, too
  std::vector<DatasetWarning> warnings;
  std::vector<PicturedScan> pictured;
  std::vector<PicturedScan> reasonImages;  // pictures of the reasons in the same scans, if these have reasons
  ObjectCounts objects;                    // in the samples whose scans were read for figures
  std::string view;                        // the scans in 3D, as scanView() writes them
  std::uint64_t seed = 0;
};

// Reads a dataset and gathers what its report shows. Throws InputError if the manifest cannot be read, and Error if no
// scan can be read. All other faults become warnings.
DatasetReport examineDataset(const std::filesystem::path& folder, const DatasetReportOptions& options);

// Returns the report as one HTML file. The same dataset with the same name, seed and options gives the same bytes.
std::string datasetPage(const DatasetReport& report);

}  // namespace scanmill
