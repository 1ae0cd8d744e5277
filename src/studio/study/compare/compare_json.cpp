// Writes compare.json. Values of figures and features have the units stated beside them. Shares of points and areas
// under ROC curves are from 0 to 1. Unknown values are NaN, which the library writes as null.

#include <nlohmann/json.hpp>

#include "config/version.h"
#include "dataset/json_text.h"
#include "study/compare/compare.h"

namespace scanmill {

namespace {

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
  return {{"effect", change.effect},
          {"key", change.key},
          {"figure", change.figure},
          {"now", change.currentValue},
          {"try", change.suggestedValue}};
}

// Returns the bands; `suffix`: appended to the keys of the values.
OrderedJson bandsJson(const std::vector<BandComparison>& bands, const std::string& suffix = "") {
  return arrayOf(bands, [&](const BandComparison& band) -> OrderedJson {
    return {{"band", band.name}, {"real" + suffix, band.real}, {"simulated" + suffix, band.simulated}};
  });
}

}  // namespace

std::string comparisonJson(const SetComparison& comparison, const std::string& date) {
  OrderedJson figures = OrderedJson::array();
  for (std::size_t i = 0; i < kSetFigureCount; ++i) {
    const ComparedFigure& figure = kSetFigures[i];
    figures.push_back({{"figure", figure.name},
                       {"unit", figure.unit},
                       {"real", comparison.real.figures[i] * figure.factor},
                       {"simulated", comparison.simulated.figures[i] * figure.factor},
                       {"keys", figure.keys}});
  }
  const OrderedJson json{{"program_version", kVersion},
                         {"date", date},
                         {"real", setJson(comparison.real)},
                         {"simulated", setJson(comparison.simulated)},
                         {"grouped_by", comparison.byClass ? "class" : "shape"},
                         {"warnings", comparison.warnings},
                         {"unknown_classes", comparison.unknownClasses},
                         {"figures", std::move(figures)},
                         {"features", arrayOf(comparison.features,
                                              [&](const Separation& s) {
                                                OrderedJson feature = separationJson(s);
                                                feature["strength_within_real"] = comparison.withinReal[s.feature];
                                                feature["keys"] = kPatchFeatures[s.feature].keys;
                                                return feature;
                                              })},
                         {"advice", arrayOf(comparison.advice, changeJson)},
                         {"set", comparison.assignment},
                         {"unadvised", comparison.unadvised},
                         {"groups", arrayOf(comparison.groups,
                                            [](const GroupComparison& group) -> OrderedJson {
                                              return {{"name", group.name},
                                                      {"real_share", group.realShare},
                                                      {"simulated_share", group.simulatedShare},
                                                      {"features", arrayOf(group.features, separationJson)}};
                                            })},
                         {"ranges", bandsJson(comparison.ranges, "_share")},
                         {"intensity_by_range", bandsJson(comparison.intensityByRange)},
                         {"intensity_by_incidence", bandsJson(comparison.intensityByIncidence)}};
  return layOut(json) + "\n";
}

}  // namespace scanmill
