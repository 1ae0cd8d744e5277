#pragma once

// How two sets of scans differ: what a network trained on one set would notice in the other.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "study/compare/scan_set.h"

namespace scanmill {

// How well a feature tells patches of the two sets apart. Only patches of the same group and band of range are
// compared, which excludes differences due to the places alone.
struct Separation {
  std::size_t feature = 0;  // index into kPatchFeatures
  // The mean over bands of |area under the ROC curve - 0.5|, weighted by the number of patches in the set that has
  // fewer: 0: no difference; 0.5: one patch is enough to tell the sets apart.
  double strength = 0;
  // The mean area under the curve, weighted alike: above 0.5 if the second set has the greater values.
  double area = 0.5;
  std::uint64_t real = 0, simulated = 0;  // numbers of patches
  // The median over all these patches; the mean for features that are mostly zero.
  double realValue = 0, simulatedValue = 0;
};

// Patches of one class or, in scans without labels, of one shape.
struct GroupComparison {
  std::string name;
  double realShare = 0, simulatedShare = 0;  // share of all patches
  std::vector<Separation> features;          // strongest first; without features that cannot be compared
};

struct BandComparison {
  std::string name;
  double realShare = 0, simulatedShare = 0;  // share of all patches
};

// Medians of intensities, in units of each set's median.
struct IntensityRow {
  std::string name;
  double real = 0, simulated = 0;  // NaN if there are too few patches
};

// A value to try in the pipeline of the second set, see study/compare/key_changes.h.
struct KeyChange {
  std::string_view effect, key;    // an effect of the pipeline, and a key of the effect
  std::string_view figure;         // the figure that suggests the change: a title of kPatchFeatures or kSetFigures
  double real = 0, simulated = 0;  // the figure as shown
  std::string_view unit;           // the unit of the figure
  double now = 0;                  // the key's value
  double next = 0;                 // the value that would make the figures equal if the key alone changed them
  bool isEnd = false;              // `next` is the largest or smallest value that the key allows, which is not enough
};

struct SetComparison {
  ScanSet real, simulated;            // without their patches
  std::vector<std::string> warnings;  // reasons why figures mean less than they seem to
  bool byClass = false;               // groups are classes; otherwise shapes
  Ontology classes;                   // the classes of the groups
  std::vector<std::string> unknown;   // classes of one set that the other set's ontology lacks
  std::vector<Separation> features;   // over all groups, the strongest first
  // Strengths between the odd and the even scans of the first set, by feature: the differences that places alone make.
  // NaN if there is only one scan.
  std::array<double, kFeatureCount> withinReal{};
  std::vector<GroupComparison> groups;  // the largest first
  std::vector<BandComparison> ranges;
  std::vector<IntensityRow> intensityByRange, intensityByIncidence;
  std::vector<KeyChange> advice;
  std::string assignment;  // an argument of --set that applies all advice; empty: none
  std::string unadvised;   // a sentence that says why there is no advice; empty if there is some
};

// Compares two sets. The classes of one set are mapped to classes of the same name or alias in the other set's
// ontology, in the direction that leaves the class shares of the sets more alike, which maps to the coarser classes. If
// one of the sets has no labels, groups are shapes.
SetComparison compareSets(ScanSet real, ScanSet simulated);

// Returns the complete comparison as JSON.
std::string comparisonJson(const SetComparison& comparison, const std::string& date);

}  // namespace scanmill
