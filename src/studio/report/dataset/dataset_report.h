#pragma once

// Writes the report of a dataset: one HTML file that can be viewed offline.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "report/dataset/dataset_summary.h"
#include "report/dataset/scan_reading.h"
#include "viewer/image.h"

namespace scanmill {

struct DatasetWarning {
  std::string text;                   // one or two sentences that are understandable without context
  std::vector<std::string> places{};  // names of the affected samples, instances or shards
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

std::vector<DatasetWarning> warningsOf(const DatasetSummary& summary, const ReadingFaults& faults);

struct DatasetReportOptions {
  std::uint64_t seed = 0;       // seed for choosing the samples that are pictured
  std::size_t samples = 4;      // number of samples that are pictured
  std::size_t mostScans = 400;  // maximum number of scans that are read for figures
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;
};

// The pictures of a scan on the page.
struct PicturedScan {
  std::string title, split;
  std::vector<std::pair<std::string, std::string>> pictures;  // pairs: meaning of the colours, contents of the PNG file
};

struct DatasetReport {
  std::string folder;  // name of the dataset's folder
  std::string path;    // path of the folder as the user gave it
  Manifest manifest;
  DatasetSummary summary;
  std::vector<std::string> shardFaults;  // one text per shard of the manifest; empty if the shard is sound
  bool hashed = false;                   // true: the SHA-256 of shards were compared
  std::vector<DatasetWarning> warnings;
  std::vector<PicturedScan> pictured;
  // Images of the reasons (scan/reasons.h) of the beams in the pictured scans; empty if the dataset has no reasons.
  std::vector<PicturedScan> reasonImages;
  ObjectCounts objects;  // counts over the samples whose scans were read for figures
  std::string view;      // JSON of the scans for the 3D view, see scanView()
  std::uint64_t seed = 0;
};

// Reads a dataset and collects the contents of its report. Throws InputError if the manifest cannot be read, and Error
// if no scan can be read. Other faults are reported as warnings.
DatasetReport examineDataset(const std::filesystem::path& folder, const DatasetReportOptions& options);

// Returns the report as an HTML file. The same dataset with the same name, seed and options always gives the same
// bytes.
std::string datasetPage(const DatasetReport& report);

}  // namespace scanmill
