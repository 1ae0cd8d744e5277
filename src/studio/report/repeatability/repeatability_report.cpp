#include "report/repeatability/repeatability_report.h"

#include "base/append_new.h"
#include "report/page/page.h"

namespace scanmill {

namespace {

// Removes the deviation of a spread of two pairs, since these are the same scans in both directions.
void dropDeviationOfTwo(Json& spread) {
  if (!spread.is_null() && spread["pairs"] < 3) spread.erase("deviation");
}

// Completes the JSON of one pose for the page's tables: `pose` itself gets the figures of the reference level, and
// `sources` gets one row for each source level.
void addTableRows(Json& pose, const Repeatability& result) {
  const std::size_t count = result.levels.size(), reference = result.reference;
  Json& fitness = pose["fitness_m2"];  // one cell for each pair of levels, by source and target
  for (Json& cell : fitness) {
    dropDeviationOfTwo(cell["registered"]);
    dropDeviationOfTwo(cell["unmoved"]);
  }
  const Json pointsOfReference = pose["points"][reference], ofReference = fitness[reference * count + reference];
  pose["points"] = pointsOfReference;
  pose.update(ofReference);
  pose["sources"] = Json::array();
  for (std::size_t source = 0; source < count; ++source) {
    Json row{{"source", result.levels[source]}, {"strong", source == reference}, {"targets", Json::array()}};
    for (std::size_t target = 0; target < count; ++target) {
      const Json& registered = pose["fitness_m2"][source * count + target]["registered"];
      row["targets"].push_back(registered.is_null() ? Json::object() : registered);
    }
    pose["sources"].push_back(std::move(row));
  }
}

}  // namespace

std::string repeatabilityReport(const Repeatability& result, const std::string& date) {
  std::vector<std::string> objects, sensors;
  for (const RepeatedView& view : result.views) {
    appendNew({view.sensor}, sensors);
    for (const RepeatedPose& pose : view.poses) appendNew({pose.object}, objects);
  }
  Json page = parseJson(repeatabilityJson(result), "repeatability.json");
  page.update({{"title", "Repeatability: " + result.pipelineName},
               {"date", date},
               {"objects", objects},
               {"sensors", sensors},
               {"warnings", result.warnings},
               {"last_seed", result.seed + result.scans - 1},
               {"ordered_pairs", std::uint64_t{result.scans} * (result.scans - 1)},
               {"several", result.methods.size() > 1}});
  for (const std::string& level : result.levels) page["targets"].push_back({{"target", level}});
  for (std::size_t m = 0; m < result.methods.size(); ++m) {
    page["of_methods"].push_back({{"number", m},
                                  {"method", result.methods[m]},
                                  {"charts", chartValues(repeatabilityCharts(result, m))},
                                  {"places", Json::array()}});
  }
  for (std::size_t v = 0; v < result.views.size(); ++v) {
    const RepeatedView& view = result.views[v];
    Json& own = page["views"][v];
    own["number"] = v;
    own["charts"] = chartValues(repeatabilityViewCharts(result, view));
    for (Json& pose : own["places"]) {
      addTableRows(pose, result);
      pose.update({{"view", view.name}, {"sensor", view.sensor}});
      page["of_methods"][view.method]["places"].push_back(pose);
    }
    if (view.method == 0) page["method_charts"].push_back(chartValues(repeatabilityMethods(result, view.name)));
  }
  // A single noise level cannot be compared with others.
  if (result.levels.size() < 2) page["views"] = Json::array();
  return fillPage(kRepeatabilityTemplate, std::move(page));
}

}  // namespace scanmill
