#pragma once

// Summarises a dataset in figures. Some figures come from the manifest and cover all scans; others need points and
// cover only the scans that were read.

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
  // Figures of all scans:
  std::uint64_t points = 0;
  std::uint64_t scans = 0;                               // scans that hold the class
  std::map<std::string, std::uint64_t> pointsOfSplit{};  // only of splits that hold the class
  // Figures of the scans that were read:
  std::vector<std::uint64_t> ranges{};  // points per step
  // Instances with points of the class, each counted once: the same id in a sequence is the same instance.
  std::uint64_t objects = 0;
  std::uint64_t views = 0;  // the same instances, counted in every scan that shows them
  double medianPoints = 0;  // median number of points of the class per instance and scan
  std::uint64_t pointsWithoutId = 0;
};

struct SensorSummary {
  std::string name;
  std::vector<std::string> methods{};
  std::uint64_t scans = 0, points = 0, beams = 0;
  std::uint64_t scansRead = 0;
  std::vector<std::uint64_t> ranges;  // points per step, of the scans that were read
  std::map<std::uint16_t, std::uint64_t> intensities{};
  ReasonCounts beamsPerReason{};  // reasons of beams in the scans that have reasons
};

struct SequenceSummary {
  std::string name;                     // prefix of the samples' keys: scene, seed and trajectory
  std::string scene, seed, trajectory;  // parts of the name, if it has them
  std::string split;                    // one split or several: "train, val"
  std::uint64_t samples = 0, scans = 0, points = 0;
  double seconds = 0;  // from the first to the last scan of the sequence
};

struct SplitSummary {
  std::string name;
  std::uint64_t samples = 0, scans = 0, points = 0, shards = 0, bytes = 0;
};

// An object: an instance id of a sequence. The figures are of the scans that were read.
struct ThingSummary {
  std::string sequence;
  std::uint32_t id = 0;
  std::map<std::uint16_t, std::uint64_t> pointsOfClass{};
  std::uint64_t points = 0, scans = 0;
  std::uint16_t mostClass = 0;  // the class of most of its points
  // Its largest length, width and height over the scans that show the object well, which see it from different sides;
  // absent if no scan does.
  std::optional<SeenSize> size{};
  // The scan with the most of its points.
  std::string bestSample{}, bestSensor{};
  std::uint64_t bestPoints = 0;
  Box bestBox{};  // the box of its points in that scan's level frame
};

// A scan shows an object well if it holds at least this number of its points.
inline constexpr std::uint64_t kWellSeenPoints = 100;

// An instance with points of several classes.
struct MixedInstance {
  std::string sequence;
  std::string sample;  // a sample that shows the class with the fewest points
  std::uint32_t id = 0;
  std::map<std::uint16_t, std::uint64_t> pointsOfClass;
  bool usual = false;  // any two of its classes often form one object, as trunk and tree do
};

// Names of remarkable scans, each with the reason: "street-s1-lane-000010, top: 12 points".
using ScanRemarks = std::vector<std::string>;

struct DatasetSummary {
  std::uint64_t samples = 0, scans = 0, points = 0, beams = 0, unresolved = 0;
  bool labelled = false;              // scans have classes
  bool instanced = false;             // scans have instances
  std::vector<ClassSummary> classes;  // the classes of the ontology in its order, then classes that it lacks
  std::vector<SensorSummary> sensors;
  std::vector<SequenceSummary> sequences;
  std::vector<SplitSummary> splits;  // in the order of the samples
  ScanRemarks emptyScans, fewPoints, unresolvedScans;

  std::uint64_t scansChosen = 0, scansRead = 0, pointsRead = 0;
  RangeSteps steps;
  std::vector<ThingSummary> things;  // in the order of sequence and id; empty if scans have no classes
  std::vector<MixedInstance> mixed;
};

// Adds up a dataset. `counts` belong to `places`; a count is absent if its scan could not be read.
DatasetSummary summarise(const Manifest& manifest, const std::vector<ScanPlace>& places,
                         const std::vector<std::optional<ScanCounts>>& counts, const RangeSteps& steps);

// A scan has few points if it has less than this share of its sensor's median.
inline constexpr double kFewPointsShare = 0.5;

}  // namespace scanmill
