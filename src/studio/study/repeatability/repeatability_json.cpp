// Writes repeatability.json. A limit that is infinite, which means no limit, is written as null.

#include "dataset/json_text.h"
#include "study/repeatability/repeatability.h"

namespace scanmill {

namespace {

// Returns the spread as JSON; null if there are no pairs, since zeros would look like perfect agreement.
OrderedJson spreadJson(const FitnessSpread& spread) {
  if (spread.count == 0) return nullptr;
  return {{"pairs", spread.count},
          {"mean", spread.mean},
          {"deviation", spread.deviation},
          {"min", spread.low},
          {"max", spread.high}};
}

// Returns a pose with the points at each noise level and the fitness between each two levels.
OrderedJson poseJson(const Repeatability& result, const RepeatedPose& pose) {
  OrderedJson json{{"frame", pose.frame}, {"object", pose.object}, {"distance_m", pose.distance}};
  json["points"] = OrderedJson::array();
  for (std::size_t level = 0; level < result.levels.size(); ++level) {
    const PointCount& count = pose.points[level];
    json["points"].push_back(
        {{"noise", result.levels[level]}, {"mean", count.mean}, {"min", count.least}, {"max", count.most}});
  }
  json["fitness_m2"] = OrderedJson::array();
  for (std::size_t source = 0; source < result.levels.size(); ++source) {
    for (std::size_t target = 0; target < result.levels.size(); ++target) {
      const LevelFitness& cell = result.at(pose, source, target);
      json["fitness_m2"].push_back({{"source", result.levels[source]},
                                    {"target", result.levels[target]},
                                    {"pairs", cell.pairs},
                                    {"registered", spreadJson(cell.registered)},
                                    {"unmoved", spreadJson(cell.unmoved)}});
    }
  }
  return json;
}

}  // namespace

std::string repeatabilityJson(const Repeatability& result) {
  OrderedJson json{{"schema", Repeatability::kSchemaVersion},
                   {"program", result.programVersion},
                   {"pipeline", {{"name", result.pipelineName}, {"text", result.pipelineText}}},
                   {"seed", result.seed},
                   {"scans", result.scans},
                   {"margin_m", result.margin},
                   {"icp",
                    {{"iterations", result.icp.iterations},
                     {"reach_m", result.icp.reach},
                     {"fitness_within_m", result.icp.fitnessWithin}}},
                   {"methods", result.methods},
                   {"noise", result.levels},
                   {"reference", result.levels[result.reference]},
                   {"views", OrderedJson::array()}};
  for (const RepeatedView& view : result.views) {
    OrderedJson poses = OrderedJson::array();
    for (const RepeatedPose& pose : view.poses) poses.push_back(poseJson(result, pose));
    json["views"].push_back(
        {{"method", result.methods[view.method]}, {"name", view.name}, {"places", std::move(poses)}});
  }
  return layOut(json) + "\n";
}

}  // namespace scanmill
