#pragma once

// Compares a real and a simulated set of scans, to find differences that a network trained on one set would notice.

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "config/value.h"
#include "study/compare/scan_set.h"

namespace scanmill {

// How well a feature of patches separates the two sets. Only patches of the same group and band of ranges are compared,
// so that different places alone cause no differences.
struct Separation {
  std::size_t feature = 0;  // index into kPatchFeatures
  // The mean of |area under the ROC curve - 0.5| over bands, weighted by the number of patches in the smaller set. 0:
  // the sets do not differ; 0.5: a single patch is enough to tell the sets apart.
  double strength = 0;
  // The mean area under the ROC curve, weighted as `strength`; above 0.5 if the simulated set has the greater values.
  double area = 0.5;
  std::uint64_t real = 0, simulated = 0;  // numbers of patches that were compared
  // The median of the feature over these patches; the mean for features that are mostly zero.
  double realValue = 0, simulatedValue = 0;
};

// Patches of one class; if the scans have no labels, patches of one shape.
struct GroupComparison {
  std::string name;
  double realShare = 0, simulatedShare = 0;  // fractions of all patches of the set
  std::vector<Separation> features;          // the strongest first; features that cannot be compared are left out
};

// A figure of both sets in one band of ranges or incidence angles.
struct BandComparison {
  std::string name;
  double real = 0, simulated = 0;  // NaN if there are too few patches
};

// A key of the simulated pipeline and a better value for it.
struct KeyChange {
  std::string_view effect, key;    // an effect of the pipeline, and a key of this effect
  std::string_view figure;         // title of the figure in kPatchFeatures or kSetFigures that suggests the change
  double real = 0, simulated = 0;  // the figure's values, as shown to users
  std::string_view unit;           // unit of the figure
  double now = 0;                  // current value of the key
  double next = 0;                 // value that would make the figures equal if nothing else influenced them
  bool isEnd = false;  // true: `next` is the end of the key's allowed range, and the figures would still differ
};

struct SetComparison {
  ScanSet real, simulated;            // measurements of both sets; their patches are removed
  std::vector<std::string> warnings;  // reasons why some figures are less meaningful than they seem
  bool byClass = false;               // true: groups are classes; false: groups are shapes of patches
  Ontology classes;                   // ontology of the groups if byClass is true
  std::vector<std::string> unknown;   // classes of one set that are missing in the ontology of the other set
  std::vector<Separation> features;   // separations over all groups together, the strongest first
  // For each feature, the strength with which it separates the odd from the even scans of the real set: differences
  // that are due to the places alone. NaN if there is only one scan, or too few patches.
  std::array<double, kFeatureCount> withinReal{};
  std::vector<GroupComparison> groups;  // sorted by the larger of realShare and simulatedShare, descending
  std::vector<BandComparison> ranges;   // fractions of each set's patches that are in the bands
  // Median intensities of patches, divided by the median of the set.
  std::vector<BandComparison> intensityByRange, intensityByIncidence;
  std::vector<KeyChange> advice;
  std::string assignment;  // argument of --set that applies all advice; empty: no advice
  std::string unadvised;   // the reason why there is no advice, as a sentence; empty if there is advice

  bool sensorsDiffer() const { return real.knowsRings && simulated.knowsRings && real.rows != simulated.rows; }
};

// Compares two sets. The classes of one set are mapped to the other set's classes with the same name or alias. The
// direction of this mapping is the one in which the class frequencies agree better; it leads to the coarser classes. If
// a set has no labels, patches are grouped by shape instead of class.
SetComparison compareSets(ScanSet real, ScanSet simulated);

// Returns the comparison as JSON. `date`: written into the JSON.
std::string comparisonJson(const SetComparison& comparison, const std::string& date);

// Returns the suggested changes. `own`: effects of the simulated sensor, as returned by sensorEffectItems(). Nothing is
// suggested for effects that the sensor lacks, for keys that are missing or not a positive number (0, lists, random
// values), or for figures that differ by less than a tenth.
std::vector<KeyChange> adviceFor(const SetComparison& comparison, const std::vector<Value>& own);

// Returns an argument of --set that applies all advice, such as "effects=[sensor, ring_bias: {gain_sigma: 0.07}]".
// `items`: the effects list of the pipeline file.
std::string assignmentOf(const std::vector<KeyChange>& advice, const std::vector<Value>& items);

// Reads the pipeline of the simulated set, and sets `advice` and `assignment` of the comparison; if there is no advice,
// sets `unadvised` to the reason. `simulated`: folder of the set. `sensor`: name of the compared sensor; empty: the
// first sensor. `pipeline`: path of the pipeline file; empty: search for the file.
void addKeyChanges(SetComparison& comparison, const std::filesystem::path& simulated, const std::string& sensor,
                   const std::filesystem::path& pipeline);

}  // namespace scanmill
