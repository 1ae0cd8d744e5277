#pragma once

// How two sets of scans differ: what a network that learns on one would notice on the other.

#include <array>
#include <cstdint>
#include <string>
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

struct SetComparison {
  ScanSet real, simulated;           // without their patches
  bool byClass = false;              // groups are classes; else shapes
  std::vector<std::string> unknown;  // classes of the second set that the first one's ontology does not have
  std::vector<Separation> features;  // over all groups, the strongest first
  // Strengths between the odd and the even scans of the first set, by feature: what places differ in. NaN where there
  // is one scan.
  std::array<double, kFeatureCount> withinReal{};
  std::vector<GroupComparison> groups;  // the largest first
  std::vector<BandComparison> ranges;
  std::vector<IntensityRow> intensityByRange, intensityByIncidence;
};

// `real` gives the classes, of which the second set's are those of the same name or alias; where one of the two has no
// labels, groups are shapes.
SetComparison compareSets(ScanSet real, ScanSet simulated);

// The whole comparison as JSON.
std::string comparisonJson(const SetComparison& comparison, const std::string& date);

}  // namespace scanmill
