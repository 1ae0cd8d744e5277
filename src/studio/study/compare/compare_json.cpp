// Writes compare.json. Fractions and areas are numbers from 0 to 1. Angles and lengths have the units stated in
// kPatchFeatures and kSetFigures. Unknown figures are null.

#include <cmath>
#include <nlohmann/json.hpp>

#include "config/version.h"
#include "dataset/json_text.h"
#include "study/compare/compare.h"

namespace scanmill {

namespace {

OrderedJson numberOrNull(double value, double factor = 1) {
  return std::isfinite(value) ? OrderedJson(value * factor) : OrderedJson();
}

OrderedJson setJson(const ScanSet& set) {
  OrderedJson json;
  json["name"] = set.name;
  json["scans"] = set.scans;
  json["scans_stored"] = set.stored;
  json["points"] = set.points;
  json["rows"] = set.rows;
  json["knows_rings"] = set.knowsRings;
  json["knows_misses"] = set.knowsMisses;
  json["labelled"] = set.labelled;
  return json;
}

OrderedJson separationJson(const Separation& s) {
  const PatchFeature& feature = kPatchFeatures[s.feature];
  OrderedJson json;
  json["feature"] = feature.name;
  json["strength"] = s.strength;
  json["area"] = s.area;
  json["unit"] = feature.unit;
  json["real_value"] = numberOrNull(s.realValue, feature.factor);
  json["simulated_value"] = numberOrNull(s.simulatedValue, feature.factor);
  json["real_patches"] = s.real;
  json["simulated_patches"] = s.simulated;
  return json;
}

OrderedJson intensityJson(const std::vector<IntensityRow>& rows) {
  OrderedJson list = OrderedJson::array();
  for (const IntensityRow& row : rows) {
    list.push_back({{"band", row.name}, {"real", numberOrNull(row.real)}, {"simulated", numberOrNull(row.simulated)}});
  }
  return list;
}

}  // namespace

std::string comparisonJson(const SetComparison& comparison, const std::string& date) {
  OrderedJson json;
  json["program_version"] = kVersion;
  json["date"] = date;
  json["real"] = setJson(comparison.real);
  json["simulated"] = setJson(comparison.simulated);
  json["grouped_by"] = comparison.byClass ? "class" : "shape";
  json["warnings"] = comparison.warnings;
  json["unknown_classes"] = comparison.unknown;
  OrderedJson figures = OrderedJson::array();
  for (std::size_t i = 0; i < kSetFigureCount; ++i) {
    const SetFigure& figure = kSetFigures[i];
    OrderedJson own;
    own["figure"] = figure.name;
    own["unit"] = figure.unit;
    own["real"] = numberOrNull(comparison.real.figures[i], figure.factor);
    own["simulated"] = numberOrNull(comparison.simulated.figures[i], figure.factor);
    own["keys"] = figure.keys;
    figures.push_back(std::move(own));
  }
  json["figures"] = std::move(figures);
  OrderedJson features = OrderedJson::array();
  for (const Separation& s : comparison.features) {
    OrderedJson own = separationJson(s);
    own["strength_within_real"] = numberOrNull(comparison.withinReal[s.feature]);
    own["keys"] = kPatchFeatures[s.feature].keys;
    features.push_back(std::move(own));
  }
  json["features"] = std::move(features);
  OrderedJson advice = OrderedJson::array();
  for (const KeyChange& a : comparison.advice) {
    advice.push_back({{"effect", a.effect}, {"key", a.key}, {"figure", a.figure}, {"now", a.now}, {"try", a.next}});
  }
  json["advice"] = std::move(advice);
  json["set"] = comparison.assignment;
  json["unadvised"] = comparison.unadvised;
  OrderedJson groups = OrderedJson::array();
  for (const GroupComparison& group : comparison.groups) {
    OrderedJson own;
    own["name"] = group.name;
    own["real_share"] = group.realShare;
    own["simulated_share"] = group.simulatedShare;
    own["features"] = OrderedJson::array();
    for (const Separation& s : group.features) own["features"].push_back(separationJson(s));
    groups.push_back(std::move(own));
  }
  json["groups"] = std::move(groups);
  OrderedJson ranges = OrderedJson::array();
  for (const BandComparison& band : comparison.ranges) {
    ranges.push_back({{"band", band.name}, {"real_share", band.realShare}, {"simulated_share", band.simulatedShare}});
  }
  json["ranges"] = std::move(ranges);
  json["intensity_by_range"] = intensityJson(comparison.intensityByRange);
  json["intensity_by_incidence"] = intensityJson(comparison.intensityByIncidence);
  return layOut(json) + "\n";
}

}  // namespace scanmill
