#pragma once

// Writes the report of a dataset: one HTML file that can be viewed offline. Some of its figures are from the manifest
// and cover all scans. Others are computed from points and cover only the scans that were read.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "charts/chart.h"
#include "dataset/manifest.h"
#include "report/dataset/scan_reading.h"
#include "viewer/image.h"

namespace scanmill {

struct ClassSummary {
  std::uint16_t id = 0;
  std::string name;
  Rgb color{};
  bool thing = false;
  bool inOntology = true;
  // Figures over all scans:
  std::uint64_t points = 0;
  std::uint64_t scans = 0;                               // number of scans with points of the class
  std::map<std::string, std::uint64_t> pointsOfSplit{};  // points in each split that has points of the class
  // Figures over the scans that were read:
  std::vector<std::uint64_t> ranges{};  // number of points in each step of DatasetSummary::steps
  // Number of instances with points of the class. The same id in several scans of a sequence is one instance.
  std::uint64_t objects = 0;
  // Number of (instance, scan) pairs in which the scan shows points of the class on the instance.
  std::uint64_t views = 0;
  double medianPoints = 0;  // median number of points of the class over the pairs in `views`
  std::uint64_t pointsWithoutId = 0;
};

struct SensorSummary {
  std::string name;
  std::vector<std::string> methods{};
  std::uint64_t scans = 0, points = 0, beams = 0;
  std::uint64_t scansRead = 0;
  // Number of points in each step of DatasetSummary::steps, over the scans that were read.
  std::vector<std::uint64_t> ranges;
  std::map<std::uint16_t, std::uint64_t> intensities{};
  ReasonCounts beamsPerReason{};  // numbers of beams by reason, over the scans that have reasons
};

struct SequenceSummary {
  std::string name;                     // first part of the samples' keys: scene, seed and trajectory
  std::string scene, seed, trajectory;  // empty if the manifest does not list the sequence
  std::string split;                    // names of the splits that have samples of the sequence, such as "train, val"
  std::uint64_t samples = 0, scans = 0, points = 0;
  double seconds = 0;  // time from the first to the last scan of the sequence (s)
};

struct SplitSummary {
  std::string name;
  std::uint64_t samples = 0, scans = 0, points = 0, shards = 0, bytes = 0;
};

// An instance whose points have classes that rarely occur together in one object.
struct MixedInstance {
  std::string sample;  // key of a sample that shows the class with the fewest points
  std::uint32_t id = 0;
  ClassPoints pointsOfClass;
};

struct DatasetSummary {
  std::uint64_t samples = 0, scans = 0, points = 0, beams = 0, unresolved = 0;
  bool labelled = false;   // true: scans have classes
  bool instanced = false;  // true: scans have instance ids
  // Classes of the ontology in its order, then classes that are missing in the ontology.
  std::vector<ClassSummary> classes;
  std::vector<SensorSummary> sensors;
  std::vector<SequenceSummary> sequences;
  std::vector<SplitSummary> splits;  // the splits, in the order in which the samples name them
  // Noteworthy scans, each with the reason, such as "street-s1-lane-000010, top: 12 points".
  std::vector<std::string> emptyScans, fewPoints, unresolvedScans;

  std::uint64_t scansChosen = 0, scansRead = 0;
  RangeSteps steps;
  std::vector<MixedInstance> mixed;
};

// Adds counts bin by bin; `sum` grows to the length of `part`.
void addTo(std::vector<std::uint64_t>& sum, const std::vector<std::uint64_t>& part);

// Computes the summary of a dataset. `counts`: counts of the scans at `places`, in this order; absent for unread scans.
DatasetSummary summarise(const Manifest& manifest, const std::vector<ScanIndex>& places,
                         const std::vector<std::optional<ScanCounts>>& counts, const RangeSteps& steps);

// A scan is reported to have few points if it has fewer than this fraction of the median number of points in its
// sensor's scans.
inline constexpr double kFewPointsShare = 0.5;

// Returns all charts of the report; a chart without data has no points.
std::vector<Chart> datasetCharts(const Manifest& manifest, const DatasetSummary& summary);

// Returns a colour as "#rrggbb".
std::string htmlColor(const Rgb& color);

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

// Returns the lines without repetitions. Lines that are equal except for their numbers become one line: the names
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

// Returns the report as an HTML file. The same dataset, name, seed and options always give the same bytes.
std::string datasetPage(const DatasetReport& report);

}  // namespace scanmill
