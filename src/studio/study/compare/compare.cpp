#include "study/compare/compare.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "base/parallel.h"
#include "config/version.h"
#include "dataset/json_text.h"
#include "evaluate/spread.h"
#include "exports/class_map.h"

namespace scanmill {

namespace {

constexpr std::size_t kFewestCompared = 50;  // a set with fewer patches in a band has no value for this band
constexpr double kUnmeasured = std::numeric_limits<double>::quiet_NaN();

// Upper bounds of the range bands (m); one more band, without an upper bound, follows the last bound.
constexpr std::array<double, 5> kRangeBands{5, 10, 20, 40, 80};
constexpr std::size_t kRangeBandCount = kRangeBands.size() + 1;

std::size_t rangeBand(float range) {
  return static_cast<std::size_t>(std::ranges::upper_bound(kRangeBands, range) - kRangeBands.begin());
}

std::string rangeBandName(std::size_t band) {
  if (band == 0) return fmt::format("to {:g} m", kRangeBands[0]);
  if (band == kRangeBands.size()) return fmt::format("beyond {:g} m", kRangeBands.back());
  return fmt::format("{:g} to {:g} m", kRangeBands[band - 1], kRangeBands[band]);
}

Groups groupsByKind(const Patches& patches) {
  Groups groups;
  for (const PatchKind kind : patches.kind) groups.ofPatch.push_back(static_cast<std::uint16_t>(kind));
  return groups;
}

// The values of a feature, by group and band of ranges (see rangeBand()).
using Strata = std::map<std::pair<std::uint16_t, std::size_t>, std::vector<float>>;

// Returns the feature's values by stratum. Ignores patches without the feature or for whose index isCompared() is
// false. `groups`: the group of each patch.
Strata strataOf(const Patches& patches, const Groups& groups, std::size_t feature, const auto& isCompared) {
  Strata strata;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const float value = patches.value[feature][i];
    if (std::isnan(value) || !isCompared(i)) continue;
    strata[{groups.ofPatch[i], rangeBand(patches.range[i])}].push_back(value);
  }
  return strata;
}

// Sums a feature's separations over strata and collects the feature's values in these strata. The weight of a stratum
// is the number of its values in the set that has fewer values there.
struct SeparationSum {
  double weight = 0;
  double strength = 0, area = 0;  // sums of |ROC area - 0.5| and of ROC area - 0.5, both times the weight
  std::vector<float> real, simulated;

  void add(const std::vector<float>& realValues, const std::vector<float>& simulatedValues) {
    const auto stratumWeight = static_cast<double>(std::min(realValues.size(), simulatedValues.size()));
    const double aboveHalf = rocArea(realValues, simulatedValues) - 0.5;
    strength += stratumWeight * std::fabs(aboveHalf);
    area += stratumWeight * aboveHalf;
    weight += stratumWeight;
    real.insert(real.end(), realValues.begin(), realValues.end());
    simulated.insert(simulated.end(), simulatedValues.begin(), simulatedValues.end());
  }

  // Returns the weighted mean over the strata, of which there must be at least one.
  Separation mean(std::size_t feature) const {
    const auto typical = [&](const std::vector<float>& values) {
      return kPatchFeatures[feature].isMostlyZero ? meanOf(values) : medianOf(values, kUnmeasured);
    };
    return {.feature = feature,
            .strength = strength / weight,
            .area = 0.5 + area / weight,
            .real = real.size(),
            .simulated = simulated.size(),
            .realValue = typical(real),
            .simulatedValue = typical(simulated)};
  }
};

struct SeparationSums {
  std::map<std::uint16_t, SeparationSum> ofGroup;
  SeparationSum all;  // sum over the strata of all groups
};

// Sums the separations of the strata in which both sets have enough patches, over each group and over all groups.
SeparationSums separate(const Strata& real, const Strata& simulated) {
  SeparationSums sums;
  for (const auto& [stratum, realValues] : real) {
    const auto found = simulated.find(stratum);
    if (found == simulated.end() || std::min(realValues.size(), found->second.size()) < kFewestCompared) continue;
    sums.ofGroup[stratum.first].add(realValues, found->second);
    sums.all.add(realValues, found->second);
  }
  return sums;
}

void sortByStrength(std::vector<Separation>& list) {
  std::ranges::stable_sort(list, std::greater<>(), &Separation::strength);
}

// Sets `ranges` of the result: for both sets, the fraction of the patches in each range band.
void addRanges(SetComparison& result) {
  const auto countsOf = [](const Patches& patches) {
    std::vector<std::uint64_t> counts(kRangeBandCount, 0);
    for (const float range : patches.range) ++counts[rangeBand(range)];
    return counts;
  };
  const auto real = countsOf(result.real.patches), simulated = countsOf(result.simulated.patches);
  for (std::size_t band = 0; band < kRangeBandCount; ++band) {
    result.ranges.push_back({rangeBandName(band), shareOf(real[band], result.real.patches.size()),
                             shareOf(simulated[band], result.simulated.patches.size())});
  }
}

// Returns the median intensities of both sets' patches in each named band; NaN if a set has too few patches in the
// band. Omits bands with too few in both. bandOf(patches, i) returns the band of patch i; a greater number for none.
std::vector<BandComparison> intensityBands(const SetComparison& result, const std::vector<std::string>& names,
                                           const auto& bandOf) {
  const auto medians = [&](const Patches& patches) {
    std::vector<std::vector<float>> intensities(names.size());
    for (std::size_t i = 0; i < patches.size(); ++i) {
      const float intensity = patches.of(Feature::Intensity)[i];
      const std::size_t band = bandOf(patches, i);
      if (!std::isnan(intensity) && band < names.size()) intensities[band].push_back(intensity);
    }
    std::vector<double> ofBands;
    ofBands.reserve(intensities.size());
    for (auto& band : intensities) {
      ofBands.push_back(band.size() < kFewestCompared ? kUnmeasured : medianOf(std::move(band)));
    }
    return ofBands;
  };
  const std::vector<double> real = medians(result.real.patches), simulated = medians(result.simulated.patches);
  std::vector<BandComparison> bands;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!std::isnan(real[i]) || !std::isnan(simulated[i])) bands.push_back({names[i], real[i], simulated[i]});
  }
  return bands;
}

// Sets `intensityByRange` and `intensityByIncidence` of the result.
void addIntensities(SetComparison& result) {
  std::vector<std::string> rangeNames;
  for (std::size_t band = 0; band < kRangeBandCount; ++band) rangeNames.push_back(rangeBandName(band));
  result.intensityByRange = intensityBands(
      result, rangeNames, [](const Patches& patches, std::size_t i) { return rangeBand(patches.range[i]); });
  constexpr double kBandDegrees = 15;  // width of a band of incidence angles
  result.intensityByIncidence = intensityBands(
      result, {"to 15 deg", "15 to 30 deg", "30 to 45 deg", "45 to 60 deg", "60 to 75 deg", "75 to 90 deg"},
      [](const Patches& patches, std::size_t i) {
        const auto incidence = static_cast<double>(patches.incidence[i]);
        return std::isnan(incidence) ? SIZE_MAX : static_cast<std::size_t>(degrees(incidence) / kBandDegrees);
      });
}

// The groups of the patches of two sets. A group is a class of one set, the owner; classes of the other set are mapped
// to the owner's. A moving class is replaced by its static class, since a patch alone does not show motion.
struct ClassGroups {
  Groups ofOwner, ofOther;                  // 0: the class is unknown to the owner
  std::vector<std::string> unknownClasses;  // names of the other set's classes that the owner lacks
};

// Returns the groups of a set's patches. groupOf(label) returns the group of a class.
Groups groupsOf(const Patches& patches, const auto& groupOf) {
  Groups groups;
  for (const std::uint16_t label : patches.label) {
    const auto [found, isNew] = groups.ofLabel.try_emplace(label);
    if (isNew) found->second = groupOf(label);
    groups.ofPatch.push_back(found->second);
  }
  return groups;
}

ClassGroups groupsByClassesOf(const ScanSet& owner, const ScanSet& other) {
  const ClassMap map(*other.ontology, *owner.ontology);
  ClassGroups groups;
  groups.ofOther = groupsOf(other.patches, [&](std::uint16_t label) {
    const SemanticClass& mapped = map.classOf(label);
    return mapped.movingOf.value_or(mapped.id);
  });
  groups.ofOwner = groupsOf(owner.patches, [&](std::uint16_t label) {
    const SemanticClass* const c = owner.ontology->find(label);
    return c == nullptr ? std::uint16_t{0} : c->movingOf.value_or(c->id);
  });
  for (const auto& [label, group] : groups.ofOther.ofLabel) {
    const SemanticClass* const c = other.ontology->find(label);
    if (group == 0 && label != 0 && c != nullptr) groups.unknownClasses.push_back(c->name);
  }
  return groups;
}

// Returns how well the class frequencies of the sets agree: 1 if each class is equally frequent in both sets and all
// patches have a known class, 0 if the sets have no class in common.
double overlapOf(const ClassGroups& groups) {
  std::map<std::uint16_t, std::pair<double, double>> shares;  // by group: share in owner's and in other set's patches
  const std::vector<std::uint16_t>&owner = groups.ofOwner.ofPatch, &other = groups.ofOther.ofPatch;
  for (const std::uint16_t g : owner) shares[g].first += 1.0 / static_cast<double>(owner.size());
  for (const std::uint16_t g : other) shares[g].second += 1.0 / static_cast<double>(other.size());
  double overlap = 0;
  for (const auto& [group, share] : shares) overlap += group == 0 ? 0 : std::min(share.first, share.second);
  return overlap;
}

// Returns the groups of the real and of the simulated set by class, and sets `classes` and `unknownClasses` of the
// result. Uses the classes of the set with which the class frequencies of the two sets agree better; those of the real
// set if the frequencies agree equally well.
std::pair<Groups, Groups> groupsByClass(SetComparison& result) {
  ClassGroups byReal = groupsByClassesOf(result.real, result.simulated);
  ClassGroups bySimulated = groupsByClassesOf(result.simulated, result.real);
  constexpr double kRounding = 1e-6;
  const bool useReal = overlapOf(byReal) + kRounding >= overlapOf(bySimulated);
  result.classes = useReal ? *result.real.ontology : *result.simulated.ontology;
  result.unknownClasses = useReal ? byReal.unknownClasses : bySimulated.unknownClasses;
  if (useReal) return {std::move(byReal.ofOwner), std::move(byReal.ofOther)};
  return {std::move(bySimulated.ofOther), std::move(bySimulated.ofOwner)};
}

// Adds the groups with shares, separations and surfaces. `real`, `simulated`: the groups of the sets' patches. `sums`:
// one per feature.
void addGroups(SetComparison& result, const Groups& real, const Groups& simulated,
               const std::vector<SeparationSums>& sums) {
  std::map<std::uint16_t, std::pair<std::uint64_t, std::uint64_t>> counts;
  for (const std::uint16_t group : real.ofPatch) ++counts[group].first;
  for (const std::uint16_t group : simulated.ofPatch) ++counts[group].second;
  const SurfacesByGroup realSurfaces = surfacesOf(result.real.patches, real, result.real.knowsMisses);
  const SurfacesByGroup simulatedSurfaces =
      surfacesOf(result.simulated.patches, simulated, result.simulated.knowsMisses);
  for (const auto& [group, count] : counts) {
    const SemanticClass* const groupClass = result.byClass ? result.classes.find(group) : nullptr;
    GroupComparison& added = result.groups.emplace_back();
    added.name = !result.byClass         ? std::string(kPatchKinds[group])
                 : groupClass == nullptr ? "unlabeled"
                                         : groupClass->name;
    added.realShare = shareOf(count.first, real.ofPatch.size());
    added.simulatedShare = shareOf(count.second, simulated.ofPatch.size());
    if (!result.byClass || group != 0) added.surfaces = compareSurfaces(realSurfaces, simulatedSurfaces, group);
    for (std::size_t f = 0; f < kFeatureCount; ++f) {
      const auto found = sums[f].ofGroup.find(group);
      if (found != sums[f].ofGroup.end()) added.features.push_back(found->second.mean(f));
    }
    sortByStrength(added.features);
  }
  std::ranges::stable_sort(result.groups, std::greater<>(),
                           [](const GroupComparison& g) { return std::max(g.realShare, g.simulatedShare); });
}

// Returns for each feature how strongly it separates the real from the simulated patches, and sets `withinReal` of the
// result. If the groups are classes, ignores patches without a class.
std::vector<SeparationSums> separateFeatures(SetComparison& result, const Groups& realGroups,
                                             const Groups& simulatedGroups) {
  const Patches &real = result.real.patches, &simulated = result.simulated.patches;
  const auto hasClass = [&](std::uint16_t group) { return !result.byClass || group != 0; };
  const auto isRealCompared = [&](std::size_t i) { return hasClass(realGroups.ofPatch[i]); };
  const auto isSimulatedCompared = [&](std::size_t i) { return hasClass(simulatedGroups.ofPatch[i]); };
  const auto isInEvenScan = [&](std::size_t i) { return isRealCompared(i) && real.scan[i] % 2 == 0; };
  const auto isInOddScan = [&](std::size_t i) { return isRealCompared(i) && real.scan[i] % 2 == 1; };
  std::vector<SeparationSums> sums(kFeatureCount);
  result.withinReal.fill(kUnmeasured);
  parallelForEach(kFeatureCount, 1, [&](std::size_t f) {
    sums[f] = separate(strataOf(real, realGroups, f, isRealCompared),
                       strataOf(simulated, simulatedGroups, f, isSimulatedCompared));
    const SeparationSum within =
        separate(strataOf(real, realGroups, f, isInEvenScan), strataOf(real, realGroups, f, isInOddScan)).all;
    if (within.weight > 0) result.withinReal[f] = within.mean(f).strength;
  });
  return sums;
}

// Returns an array with the JSON of each item of a list.
OrderedJson arrayOf(const auto& list, const auto& jsonOf) {
  OrderedJson array = OrderedJson::array();
  for (const auto& item : list) array.push_back(jsonOf(item));
  return array;
}

OrderedJson setJson(const ScanSet& set) {
  return {{"name", set.name},
          {"scans", set.scans},
          {"scans_stored", set.stored},
          {"points", set.points},
          {"rows", set.rows},
          {"knows_rings", set.knowsRings},
          {"knows_misses", set.knowsMisses},
          {"labelled", set.labelled}};
}

OrderedJson separationJson(const Separation& s) {
  const ComparedFigure& feature = kPatchFeatures[s.feature];
  return {{"feature", feature.name},
          {"strength", s.strength},
          {"area", s.area},
          {"unit", feature.unit},
          {"real_value", s.realValue * feature.factor},
          {"simulated_value", s.simulatedValue * feature.factor},
          {"real_patches", s.real},
          {"simulated_patches", s.simulated}};
}

OrderedJson changeJson(const KeyChange& change) {
  return {{"key", change.key},
          {"figure", change.figure.title},
          {"now", change.current},
          {"try", change.suggested},
          {"try_deviation", change.deviation}};
}

// Returns null if no scan shows the figure.
OrderedJson spreadJson(const FigureSpread& spread) {
  if (std::isnan(spread.median)) return nullptr;
  return {{"median", spread.median},
          {"percentile_16", spread.low},
          {"percentile_84", spread.high},
          {"deviation_over_sequences", spread.overSequences}};
}

// Returns the bands as a JSON array. `suffix`: appended to the keys of the values.
OrderedJson bandsJson(const std::vector<BandComparison>& bands, const std::string& suffix = "") {
  return arrayOf(bands, [&](const BandComparison& band) -> OrderedJson {
    return {{"band", band.name}, {"real" + suffix, band.real}, {"simulated" + suffix, band.simulated}};
  });
}

OrderedJson surfaceJson(const SurfaceComparison& surface) {
  OrderedJson json{{"band", surface.band}, {"real_pixels", surface.realPixels}};
  for (std::size_t f = 0; f < kSurfaceFigureCount; ++f) {
    json[kSurfaceFigures[f].name] = {
        {"unit", kSurfaceFigures[f].unit}, {"real", surface.real[f]}, {"simulated", surface.simulated[f]}};
  }
  return json;
}

}  // namespace

std::pair<std::size_t, std::size_t> SetComparison::surfacesAlike() const {
  std::size_t alike = 0, all = 0;
  for (const GroupComparison& group : groups) {
    for (const SurfaceComparison& band : group.surfaces) {
      for (std::size_t f = 0; f < kSurfaceFigureCount; ++f) {
        all += band.isCounted(f) ? 1 : 0;
        alike += band.isCounted(f) && band.isAlike(f) ? 1 : 0;
      }
    }
  }
  return {alike, all};
}

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
  if (!result.byClass || std::isnan(result.real.roadPose[kHeight].median - result.simulated.roadPose[kHeight].median)) {
    for (ScanSet* set : {&result.real, &result.simulated}) set->roadPose = set->roadPoseByShape;
  }
  const std::vector<SeparationSums> sums = separateFeatures(result, realGroups, simulatedGroups);
  for (std::size_t f = 0; f < kFeatureCount; ++f) {
    if (sums[f].all.weight > 0) result.features.push_back(sums[f].all.mean(f));
  }
  sortByStrength(result.features);
  std::ranges::stable_sort(result.features, {},
                           [](const Separation& s) { return kPatchFeatures[s.feature].isOfScene; });
  addGroups(result, realGroups, simulatedGroups, sums);
  addRanges(result);
  addIntensities(result);
  result.real.patches = {};
  result.simulated.patches = {};
  return result;
}

// Values of figures and features have the units stated beside them. Shares of points and areas under ROC curves are
// from 0 to 1. Unknown values are NaN, which the library writes as null.
std::string comparisonJson(const SetComparison& comparison, const std::string& date) {
  OrderedJson figures = OrderedJson::array();
  for (std::size_t i = 0; i < kSetFigureCount; ++i) {
    const ComparedFigure& figure = kSetFigures[i];
    figures.push_back({{"figure", figure.name},
                       {"unit", figure.unit},
                       {"real", comparison.real.figures[i] * figure.factor},
                       {"simulated", comparison.simulated.figures[i] * figure.factor},
                       {"only_scene", figure.isOfScene},
                       {"keys", figure.keys}});
  }
  const RoadPoses &realPose = comparison.real.roadPose, &simulatedPose = comparison.simulated.roadPose;
  OrderedJson roadPose = OrderedJson::array();
  for (std::size_t f = 0; f < kRoadFigureCount; ++f) {
    roadPose.push_back({{"figure", kRoadFigures[f].name},
                        {"unit", kRoadFigures[f].unit},
                        {"real", spreadJson(realPose[f])},
                        {"simulated", spreadJson(simulatedPose[f])},
                        {"difference", differenceText(f, realPose, simulatedPose)}});
  }
  const OrderedJson features = arrayOf(comparison.features, [&](const Separation& s) {
    OrderedJson feature = separationJson(s);
    feature["strength_within_real"] = comparison.withinReal[s.feature];
    feature["only_scene"] = kPatchFeatures[s.feature].isOfScene;
    feature["keys"] = kPatchFeatures[s.feature].keys;
    return feature;
  });
  const OrderedJson groups = arrayOf(comparison.groups, [](const GroupComparison& group) -> OrderedJson {
    return {{"name", group.name},
            {"real_share", group.realShare},
            {"simulated_share", group.simulatedShare},
            {"features", arrayOf(group.features, separationJson)},
            {"surfaces", arrayOf(group.surfaces, surfaceJson)}};
  });
  const OrderedJson json{{"program_version", kVersion},
                         {"date", date},
                         {"real", setJson(comparison.real)},
                         {"simulated", setJson(comparison.simulated)},
                         {"grouped_by", comparison.byClass ? "class" : "shape"},
                         {"warnings", comparison.warnings},
                         {"unknown_classes", comparison.unknownClasses},
                         {"road_pose", roadPose},
                         {"figures", figures},
                         {"features", features},
                         {"surfaces_alike", comparison.surfacesAlike().first},
                         {"surfaces_compared", comparison.surfacesAlike().second},
                         {"advice", arrayOf(comparison.advice, changeJson)},
                         {"set", comparison.assignments},
                         {"unadvised", comparison.unadvised},
                         {"groups", groups},
                         {"ranges", bandsJson(comparison.ranges, "_share")},
                         {"intensity_by_range", bandsJson(comparison.intensityByRange)},
                         {"intensity_by_incidence", bandsJson(comparison.intensityByIncidence)}};
  return layOut(json) + "\n";
}

}  // namespace scanmill
