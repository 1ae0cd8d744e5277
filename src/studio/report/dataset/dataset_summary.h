#pragma once

// What a dataset holds, in figures. Some of them are of all scans, as far as the manifest knows; others are of the
// scans that were read, since only points tell them.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "report/dataset/scan_choice.h"
#include "report/dataset/scan_counts.h"
#include "viewer/image.h"

namespace scanmill {

struct ClassSummary {
  std::uint16_t id = 0;
  std::string name;
  Rgb color{};
  bool thing = false;
  bool known = true;  // the ontology has the class
  // Of all scans.
  std::uint64_t points = 0;
  std::uint64_t scans = 0;                               // scans that hold the class
  std::map<std::string, std::uint64_t> pointsOfSplit{};  // only of splits that hold the class
  // Of the scans that were read.
  std::vector<std::uint64_t> ranges{};  // points per step
  // Instances with points of the class, each counted once: the same id in a sequence is the same instance.
  std::uint64_t objects = 0;
  std::uint64_t views = 0;  // the same instances, counted in every scan that shows them
  double medianPoints = 0;  // the median number of points of the class that an instance has in a scan
  std::uint64_t pointsWithoutId = 0;
};

struct SensorSummary {
  std::string name;
  std::vector<std::string> methods{};
  std::uint64_t scans = 0, points = 0, beams = 0;
  std::uint64_t scansRead = 0;
  std::vector<std::uint64_t> ranges;  // points per step, of the scans that were read
  std::map<std::uint16_t, std::uint64_t> intensities{};
  ReasonCounts beamsPerReason{};  // of the scans that have them
};

struct SequenceSummary {
  std::string name;                     // what the samples' keys begin with: scene, seed and trajectory
  std::string scene, seed, trajectory;  // the parts of the name, where it has them
  std::string split;                    // one split or several: "train, val"
  std::uint64_t samples = 0, scans = 0, points = 0;
  double seconds = 0;  // from its first to its last scan
};

struct SplitSummary {
  std::string name;
  std::uint64_t samples = 0, scans = 0, points = 0, shards = 0, bytes = 0;
};

// A thing is an instance id of a sequence; the figures are of the scans that were read.
struct ThingSummary {
  std::string sequence;
  std::uint32_t id = 0;
  std::map<std::uint16_t, std::uint64_t> pointsOfClass{};
  std::uint64_t points = 0, scans = 0;
  std::uint16_t mostClass = 0;  // the class that most of its points have
  // Its largest length, width and height over the scans that show it well, which see it from different sides; absent
  // where none does.
  std::optional<SeenSize> size{};
  // The scan that has the most of its points.
  std::string bestSample{}, bestSensor{};
  std::uint64_t bestPoints = 0;
  Box bestBox{};  // the box of its points in that scan's level frame
};

// A scan shows a thing well with so many points of it.
inline constexpr std::uint64_t kWellSeenPoints = 100;

// An instance with points of several classes.
struct MixedInstance {
  std::string sequence;
  std::string sample;  // a sample that shows the class with the fewest points
  std::uint32_t id = 0;
  std::map<std::uint16_t, std::uint64_t> pointsOfClass;
  bool usual = false;  // every two of its classes often make one thing, as trunk and tree do
};

// Names of scans with what is remarkable about each: "street-s1-lane-000010, top: 12 points".
using ScanRemarks = std::vector<std::string>;

struct DatasetSummary {
  std::uint64_t samples = 0, scans = 0, points = 0, beams = 0, unresolved = 0;
  bool labelled = false;              // scans have classes
  bool instanced = false;             // scans have instances
  std::vector<ClassSummary> classes;  // those of the ontology in its order, then those that it does not know
  std::vector<SensorSummary> sensors;
  std::vector<SequenceSummary> sequences;
  std::vector<SplitSummary> splits;  // in the order of the samples
  ScanRemarks emptyScans, fewPoints, unresolvedScans;

  std::uint64_t scansChosen = 0, scansRead = 0, pointsRead = 0;
  RangeSteps steps;
  std::vector<ThingSummary> things;  // in the order of sequence and id; only where scans have classes
  std::vector<MixedInstance> mixed;
};

// Adds up a dataset. `counts` belong to `places`; they are absent where a scan could not be read.
DatasetSummary summarise(const Manifest& manifest, const std::vector<ScanPlace>& places,
                         const std::vector<std::optional<ScanCounts>>& counts, const RangeSteps& steps);

// A scan with less than this share of its sensor's median has few points.
inline constexpr double kFewPointsShare = 0.5;

}  // namespace scanmill
