#pragma once

// What a dataset holds, in figures: of all its scans what the manifest knows, of those that were read what points tell.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "study/dataset/scan_choice.h"
#include "study/dataset/scan_counts.h"
#include "viewer/image.h"

namespace scanmill {

struct ClassSummary {
  std::uint16_t id = 0;
  std::string name;
  Rgb color{};
  bool thing = false;
  bool known = true;  // to the ontology
  // Of all scans.
  std::uint64_t points = 0;
  std::uint64_t scans = 0;                               // that hold the class
  std::map<std::string, std::uint64_t> pointsOfSplit{};  // only splits that hold the class
  // Of the scans that were read.
  std::vector<std::uint64_t> ranges{};  // points per step
  // Instances with points of the class, however many scans show them: the same id in a sequence is the same one.
  std::uint64_t objects = 0;
  std::uint64_t views = 0;  // instances, counted again in every scan
  double medianPoints = 0;  // that an instance in a scan has of the class
  std::uint64_t pointsWithoutId = 0;
};

struct SensorSummary {
  std::string name;
  std::vector<std::string> methods;
  std::uint64_t scans = 0, points = 0, beams = 0, emptyScans = 0;
  std::uint64_t medianPoints = 0;  // a scan
  std::uint64_t scansRead = 0;
  std::vector<std::uint64_t> ranges;  // points per step, of the scans that were read
  std::map<std::uint16_t, std::uint64_t> intensities;
};

struct SequenceSummary {
  std::string name;                     // of the samples' keys: scene, seed and trajectory
  std::string scene, seed, trajectory;  // its parts, where it has them
  std::string split;                    // or several: "train, val"
  std::uint64_t samples = 0, scans = 0, points = 0;
  double seconds = 0;  // from its first to its last scan
};

struct SplitSummary {
  std::string name;
  std::uint64_t samples = 0, scans = 0, points = 0, shards = 0, bytes = 0;
};

// A thing: an instance id of a sequence, in the scans that were read.
struct ThingSummary {
  std::string sequence;
  std::uint32_t id = 0;
  std::map<std::uint16_t, std::uint64_t> pointsOfClass{};
  std::uint64_t points = 0, scans = 0;
  std::uint16_t mostClass = 0;  // of most of its points
  // The largest over the scans that show it well; absent where none does. They see its length, width and height from
  // different sides.
  std::optional<SeenSize> size{};
  // The scan with most of its points.
  std::string bestSample{}, bestSensor{};
  std::uint64_t bestPoints = 0;
  Box bestBox{};  // in that scan's level frame
};

// A scan shows a thing well with so many points of it.
inline constexpr std::uint64_t kWellSeenPoints = 100;

// An object with points of several classes.
struct MixedInstance {
  std::string sequence;
  std::string sample;  // one that shows the class with fewer points
  std::uint32_t id = 0;
  std::map<std::uint16_t, std::uint64_t> pointsOfClass;
  bool usual = false;  // every two of its classes often make one thing: trunk and tree
};

// Samples, and what is remarkable about a scan of each: "street-s1-lane-000010, top: 12 points".
using ScanRemarks = std::vector<std::string>;

struct DatasetSummary {
  std::uint64_t samples = 0, scans = 0, points = 0, beams = 0, unresolved = 0;
  bool labelled = false;              // scans have classes
  bool instanced = false;             // and instances
  std::vector<ClassSummary> classes;  // of the ontology, in its order, then those it does not know
  std::vector<SensorSummary> sensors;
  std::vector<SequenceSummary> sequences;
  std::vector<SplitSummary> splits;  // in the order of the samples
  ScanRemarks emptyScans, fewPoints, unresolvedScans;

  std::uint64_t scansChosen = 0, scansRead = 0, pointsRead = 0;
  RangeSteps steps;
  std::vector<ThingSummary> things;  // by sequence and id; of labelled scans
  std::vector<MixedInstance> mixed;
};

// `counts` are of `places`; empty where a scan could not be read.
DatasetSummary summarise(const Manifest& manifest, const std::vector<ScanPlace>& places,
                         const std::vector<std::optional<ScanCounts>>& counts, const RangeSteps& steps);

// Scans below this share of their sensor's median have few points.
inline constexpr double kFewPointsShare = 0.5;

}  // namespace scanmill
