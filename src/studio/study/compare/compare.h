#pragma once

// How two sets of scans differ: what a network that learns on one would notice on the other.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "study/compare/scan_set.h"

namespace scanmill {

// How well a feature tells patches of the two sets apart that are of one group and one band of range: what differs is
// then not that the places differ.
struct Separation {
  std::size_t feature = 0;  // into kPatchFeatures
  // The mean over bands of |area under the ROC curve - 0.5|, weighted by the fewer patches of the two: 0 no difference,
  // 0.5 one patch suffices.
  double strength = 0;
  // The area itself, likewise: above 0.5 where the second set has the greater values.
  double area = 0.5;
  std::uint64_t real = 0, simulated = 0;  // patches
  // The median over all these patches, or the mean of features that are mostly zero.
  double realValue = 0, simulatedValue = 0;
};

// Patches of one class or, of scans without labels, of one shape.
struct GroupComparison {
  std::string name;
  double realShare = 0, simulatedShare = 0;  // of all patches
  std::vector<Separation> features;          // the strongest first; those that cannot be compared are left out
};

struct BandComparison {
  std::string name;
  double realShare = 0, simulatedShare = 0;  // of all patches
};

// Medians of intensities, in units of each set's median.
struct IntensityRow {
  std::string name;
  double real = 0, simulated = 0;  // NaN where there are too few patches
};

// A value to try in the pipeline of the second set, see study/compare/key_changes.h.
struct KeyChange {
  std::string_view effect, key;    // of the pipeline's effects
  std::string_view figure;         // that tells of it: a title of kPatchFeatures or kSetFigures
  double real = 0, simulated = 0;  // the figure, as it is shown
  std::string_view unit;           // of it
  double now = 0;                  // the key's value
  double next = 0;                 // one that would make the figures alike, if it alone moved them
  bool isEnd = false;              // `next` is the most or the least that the key takes, which is not enough
};

struct SetComparison {
  ScanSet real, simulated;            // without their patches
  std::vector<std::string> warnings;  // what makes figures mean less than they say
  bool byClass = false;               // groups are classes; else shapes
  Ontology classes;                   // of the groups
  std::vector<std::string> unknown;   // classes of one set that the other one's ontology does not have
  std::vector<Separation> features;   // over all groups, the strongest first
  // Strengths between the odd and the even scans of the first set, by feature: what places differ in. NaN where there
  // is one scan.
  std::array<double, kFeatureCount> withinReal{};
  std::vector<GroupComparison> groups;  // the largest first
  std::vector<BandComparison> ranges;
  std::vector<IntensityRow> intensityByRange, intensityByIncidence;
  std::vector<KeyChange> advice;
  std::string assignment;  // an argument of --set that follows all advice; empty: none
  std::string unadvised;   // why there is no advice, a sentence; empty where there is some
};

// Classes of one set become those of the same name or alias in the other one's ontology: of the two ways the one that
// leaves the sets more alike in their shares, which is that to the coarser classes. Where one of the sets has no
// labels, groups are shapes.
SetComparison compareSets(ScanSet real, ScanSet simulated);

// The whole comparison as JSON.
std::string comparisonJson(const SetComparison& comparison, const std::string& date);

}  // namespace scanmill
