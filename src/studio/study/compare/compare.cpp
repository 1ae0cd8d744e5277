#include "study/compare/compare.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "base/parallel.h"
#include "evaluate/spread.h"
#include "exports/class_map.h"

namespace scanmill {

namespace {

constexpr std::size_t kFewestInGroup = 50;  // a band with fewer patches of a set has no figure for this set
constexpr double kUnmeasured = std::numeric_limits<double>::quiet_NaN();

// The group number of each patch. Equal numbers mean the same group in both sets.
using Groups = std::vector<std::uint16_t>;

Groups groupsByKind(const Patches& patches) {
  Groups groups;
  for (const PatchKind kind : patches.kind) groups.push_back(static_cast<std::uint16_t>(kind));
  return groups;
}

// The values of a feature, by group and band of ranges.
using Strata = std::map<std::pair<std::uint16_t, std::size_t>, std::vector<float>>;

Strata strataOf(const Patches& patches, const Groups& groups, std::size_t feature, const auto& wanted) {
  Strata strata;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const float value = patches.value[feature][i];
    if (std::isnan(value) || !wanted(i)) continue;
    strata[{groups[i], comparedBandOf(static_cast<double>(patches.range[i]))}].push_back(value);
  }
  return strata;
}

// The sum over bands of the separations times their weights, and all values of the feature.
struct SeparationSum {
  Separation weighted;
  double weight = 0;
  std::vector<float> real, simulated;

  // Adds the values of both sets in one band.
  void add(const std::vector<float>& ofReal, const std::vector<float>& ofSimulated) {
    const auto bandWeight = static_cast<double>(std::min(ofReal.size(), ofSimulated.size()));
    const double area = rocArea(ofReal, ofSimulated);
    weighted.strength += bandWeight * std::fabs(area - 0.5);
    weighted.area += bandWeight * (area - 0.5);
    weight += bandWeight;
    real.insert(real.end(), ofReal.begin(), ofReal.end());
    simulated.insert(simulated.end(), ofSimulated.begin(), ofSimulated.end());
  }

  Separation mean(std::size_t feature) const {
    Separation s = weighted;
    s.feature = feature;
    s.strength /= weight;
    s.area = 0.5 + (weighted.area - 0.5) / weight;
    s.real = real.size();
    s.simulated = simulated.size();
    const bool isMostlyZero = kPatchFeatures[feature].isMostlyZero;
    s.realValue = isMostlyZero ? meanOf(real) : medianOf(real, kUnmeasured);
    s.simulatedValue = isMostlyZero ? meanOf(simulated) : medianOf(simulated, kUnmeasured);
    return s;
  }
};

struct SeparationSums {
  std::map<std::uint16_t, SeparationSum> ofGroup;
  SeparationSum all;
};

SeparationSums separate(const Strata& real, const Strata& simulated) {
  SeparationSums sums;
  for (const auto& [stratum, values] : real) {
    const auto same = simulated.find(stratum);
    if (same == simulated.end() || std::min(values.size(), same->second.size()) < kFewestInGroup) continue;
    sums.ofGroup[stratum.first].add(values, same->second);
    sums.all.add(values, same->second);
  }
  return sums;
}

void sortByStrength(std::vector<Separation>& list) {
  std::ranges::stable_sort(list, std::greater<>(), &Separation::strength);
}

void addRanges(SetComparison& result) {
  const auto countsOf = [](const Patches& patches) {
    std::vector<std::uint64_t> counts(kRangeBandCount, 0);
    for (const float range : patches.range) ++counts[comparedBandOf(static_cast<double>(range))];
    return counts;
  };
  const auto real = countsOf(result.real.patches), simulated = countsOf(result.simulated.patches);
  for (std::size_t band = 0; band < kRangeBandCount; ++band) {
    result.ranges.push_back({comparedBandName(band), shareOf(real[band], result.real.patches.size()),
                             shareOf(simulated[band], result.simulated.patches.size())});
  }
}

// Returns the median intensities of the patches in each row. bandOf(patches, i) returns the row of the patch i; an
// index beyond the last row if the patch belongs to none.
std::vector<BandComparison> intensityRows(const SetComparison& result, const std::vector<std::string>& names,
                                          const auto& bandOf) {
  const auto medians = [&](const Patches& patches) {
    std::vector<std::vector<float>> values(names.size());
    for (std::size_t i = 0; i < patches.size(); ++i) {
      const float intensity = patches.of(Feature::Intensity)[i];
      const std::size_t band = bandOf(patches, i);
      if (!std::isnan(intensity) && band < names.size()) values[band].push_back(intensity);
    }
    std::vector<double> list;
    list.reserve(values.size());
    for (auto& own : values) list.push_back(own.size() < kFewestInGroup ? kUnmeasured : medianOf(std::move(own)));
    return list;
  };
  const std::vector<double> real = medians(result.real.patches), simulated = medians(result.simulated.patches);
  std::vector<BandComparison> rows;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!std::isnan(real[i]) || !std::isnan(simulated[i])) rows.push_back({names[i], real[i], simulated[i]});
  }
  return rows;
}

void addIntensities(SetComparison& result) {
  std::vector<std::string> bands;
  for (std::size_t band = 0; band < kRangeBandCount; ++band) bands.push_back(comparedBandName(band));
  result.intensityByRange = intensityRows(result, bands, [](const Patches& patches, std::size_t i) {
    return comparedBandOf(static_cast<double>(patches.range[i]));
  });
  constexpr double kBand = 15;  // width of a band of incidence angles (degrees)
  result.intensityByIncidence = intensityRows(
      result, {"to 15 deg", "15 to 30 deg", "30 to 45 deg", "45 to 60 deg", "60 to 75 deg", "75 to 90 deg"},
      [](const Patches& patches, std::size_t i) {
        const auto incidence = static_cast<double>(patches.incidence[i]);
        return std::isnan(incidence) ? std::size_t{99} : static_cast<std::size_t>(degrees(incidence) / kBand);
      });
}

// The groups of the patches in the sets `owner` and `other` (see groupsByClassesOf()) by the classes of `owner`, and
// the names of classes that only `other` has.
struct ClassGroups {
  Groups own, other;
  std::vector<std::string> unknown;
};

ClassGroups groupsByClassesOf(const ScanSet& owner, const ScanSet& other) {
  const ClassMap map(*other.ontology, *owner.ontology);
  ClassGroups groups;
  std::set<std::uint16_t> lost;
  // A moving class is replaced by the corresponding static class, since a patch alone does not show motion.
  for (const std::uint16_t label : other.patches.label) {
    const SemanticClass& mapped = map.classOf(label);
    groups.other.push_back(mapped.movingOf.value_or(mapped.id));
    if (groups.other.back() == 0 && label != 0) lost.insert(label);
  }
  for (const std::uint16_t label : lost) {
    const SemanticClass* const own = other.ontology->find(label);
    if (own != nullptr) groups.unknown.push_back(own->name);
  }
  for (const std::uint16_t label : owner.patches.label) {
    const SemanticClass* const own = owner.ontology->find(label);
    groups.own.push_back(own == nullptr ? std::uint16_t{0} : own->movingOf.value_or(own->id));
  }
  return groups;
}

// Returns how well the class frequencies of the sets agree: 1 if each class is equally frequent in both sets, 0 if they
// have no class in common.
double overlapOf(const ClassGroups& groups) {
  std::map<std::uint16_t, std::pair<double, double>> shares;
  for (const std::uint16_t g : groups.own) shares[g].first += 1.0 / static_cast<double>(groups.own.size());
  for (const std::uint16_t g : groups.other) shares[g].second += 1.0 / static_cast<double>(groups.other.size());
  double overlap = 0;
  for (const auto& [group, share] : shares) overlap += group == 0 ? 0 : std::min(share.first, share.second);
  return overlap;
}

// Groups the patches of the real and of the simulated set by class, and returns the groups of both. Both sets are
// labelled with the classes of one of them: whichever make the class frequencies of the two sets agree better.
std::pair<Groups, Groups> groupsByClass(SetComparison& result) {
  ClassGroups byReal = groupsByClassesOf(result.real, result.simulated);
  ClassGroups bySimulated = groupsByClassesOf(result.simulated, result.real);
  constexpr double kClearly = 1e-6;
  const bool real = overlapOf(byReal) + kClearly >= overlapOf(bySimulated);
  result.classes = real ? *result.real.ontology : *result.simulated.ontology;
  result.unknown = real ? byReal.unknown : bySimulated.unknown;
  if (real) return {std::move(byReal.own), std::move(byReal.other)};
  return {std::move(bySimulated.other), std::move(bySimulated.own)};
}

void addGroups(SetComparison& result, const Groups& real, const Groups& simulated,
               const std::vector<SeparationSums>& sums) {
  std::map<std::uint16_t, std::pair<std::uint64_t, std::uint64_t>> counts;
  for (const std::uint16_t group : real) ++counts[group].first;
  for (const std::uint16_t group : simulated) ++counts[group].second;
  for (const auto& [group, count] : counts) {
    GroupComparison own;
    const SemanticClass* const known = result.byClass ? result.classes.find(group) : nullptr;
    own.name = !result.byClass ? std::string(kPatchKinds[group]) : known == nullptr ? "unlabeled" : known->name;
    own.realShare = shareOf(count.first, real.size());
    own.simulatedShare = shareOf(count.second, simulated.size());
    for (std::size_t f = 0; f < kFeatureCount; ++f) {
      const auto found = sums[f].ofGroup.find(group);
      if (found != sums[f].ofGroup.end()) own.features.push_back(found->second.mean(f));
    }
    sortByStrength(own.features);
    result.groups.push_back(std::move(own));
  }
  std::ranges::stable_sort(result.groups, std::greater<>(),
                           [](const GroupComparison& g) { return std::max(g.realShare, g.simulatedShare); });
}

// Returns the separations by each feature, and sets `withinReal` of the result. Patches without a class, or with a
// class that only one set has, are not compared.
std::vector<SeparationSums> separateFeatures(SetComparison& result, const Groups& realGroups,
                                             const Groups& simulatedGroups) {
  const Patches &real = result.real.patches, &simulated = result.simulated.patches;
  const auto isKnown = [&](std::uint16_t group) { return !result.byClass || group != 0; };
  std::vector<SeparationSums> sums(kFeatureCount);
  result.withinReal.fill(kUnmeasured);
  parallelFor(kFeatureCount, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const auto known = [&](std::size_t i) { return isKnown(realGroups[i]); };
      const auto even = [&](std::size_t i) { return known(i) && real.scan[i] % 2 == 0; };
      const auto odd = [&](std::size_t i) { return known(i) && real.scan[i] % 2 == 1; };
      sums[f] =
          separate(strataOf(real, realGroups, f, known),
                   strataOf(simulated, simulatedGroups, f, [&](std::size_t i) { return isKnown(simulatedGroups[i]); }));
      const SeparationSum within =
          separate(strataOf(real, realGroups, f, even), strataOf(real, realGroups, f, odd)).all;
      if (within.weight > 0) result.withinReal[f] = within.mean(f).strength;
    }
  });
  return sums;
}

}  // namespace

SetComparison compareSets(ScanSet realSet, ScanSet simulatedSet) {
  SetComparison result;
  result.real = std::move(realSet);
  result.simulated = std::move(simulatedSet);
  result.byClass = result.real.labelled && result.simulated.labelled;
  const auto [realGroups, simulatedGroups] =
      result.byClass ? groupsByClass(result)
                     : std::pair(groupsByKind(result.real.patches), groupsByKind(result.simulated.patches));
  if (result.sensorsDiffer()) {
    result.warnings.push_back(
        fmt::format("{} has {} rings, but {} has {}: the patches of different sensors differ already by their beams, "
                    "so compare scans of one sensor",
                    result.real.name, result.real.rows, result.simulated.name, result.simulated.rows));
  }
  const std::vector<SeparationSums> sums = separateFeatures(result, realGroups, simulatedGroups);
  for (std::size_t f = 0; f < kFeatureCount; ++f) {
    if (sums[f].all.weight > 0) result.features.push_back(sums[f].all.mean(f));
  }
  sortByStrength(result.features);
  addGroups(result, realGroups, simulatedGroups, sums);
  addRanges(result);
  addIntensities(result);
  result.real.patches = {};
  result.simulated.patches = {};
  return result;
}

}  // namespace scanmill
