#include "report/tradeoff/report.h"

#include <fmt/core.h>

#include <algorithm>
#include <optional>

#include "base/append_new.h"
#include "base/hash.h"
#include "base/short_text.h"
#include "methods/method.h"
#include "pipeline/read/pipeline.h"
#include "report/page/page.h"
#include "study/figure_text.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostColumns = 6;  // maximum number of settings in the table of classes

// Returns `json`, the JSON of `errors` in tradeoff.json, with added derived figures and without empty spreads.
Json errorsJson(Json json, const GroupErrors& errors) {
  for (const char* spread : {"range_m", "intensity", "nearest_to_m", "nearest_from_m"}) {
    if (json.at(spread).at("count") == 0) json.erase(spread);
  }
  json.update({{"labels", errors.labels()},
               {"classes", errors.classAgreed()},
               {"instances", errors.instanceAgreed()},
               {"miss_rate", errors.missRate()}});
  const std::uint64_t trueHits = errors.bothHit + errors.falseNegatives;
  if (trueHits > 0) json["false_negative_share"] = shareOf(errors.falseNegatives, trueHits);
  if (errors.nearestTo.count + errors.nearestFrom.count > 0) json["hausdorff_m"] = errors.hausdorff();
  return json;
}

// Returns the figures of the group with this name; an empty object if the group has no beams. `json`: the JSON of the
// groups in tradeoff.json.
Json groupJson(const Json& json, const std::vector<ErrorGroup>& groups, const std::string& name) {
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (groups[i].name == name && groups[i].errors.beams > 0) return errorsJson(json[i].at("errors"), groups[i].errors);
  }
  return Json::object();
}

// Converts the JSON of tradeoff.json to the values of the page's template.
class StudyPage {
 public:
  explicit StudyPage(const Study& study)
      : study_(study), file_(parseJson(toJson(study), "tradeoff.json")), page_(file_) {}

  Json values() {
    addFacts();
    addPictures();
    addOtherClasses();
    addSettings();
    addPlaces();
    addClasses();
    addStages();
    addUse();
    page_["charts"] = chartValues(studyCharts(study_));
    return std::move(page_);
  }

 private:
  const BeamErrors& errors(std::size_t i) const { return study_.settings[i].measured.errors; }
  const Json& errorsOf(std::size_t i) const { return file_["settings"][i]["measured"]["errors"]; }
  const std::string& nameOf(std::size_t i) const { return study_.settings[i].setting.name; }

  // Adds the facts about the study and the pipeline.
  void addFacts() {
    const std::size_t measured = measuredSettings(study_).size();
    page_.update({{"title", "Speed against accuracy: " + study_.pipelineName},
                  {"scene_frames", study_.scene.frames.size() == 1 ? "frame" : "frames"},
                  {"timed", fmt::format("{}{}", study_.repeats == 1 ? "once" : fmt::format("{} times", study_.repeats),
                                        study_.shots == 1 ? "" : " each")},
                  {"measured_settings", measured},
                  {"failed_settings", study_.settings.size() - measured},
                  {"duration", study_.seconds > 0 ? shortTime(study_.seconds) : ""},
                  {"pipeline_word", study_.pipelineFile.empty() ? "PIPELINE.yaml" : shellWord(study_.pipelineFile)},
                  {"dataset_word", shellWord("out/" + study_.pipelineName)}});
    if (study_.budgetGiven && study_.budgetSeconds > 0) {
      page_["budget_minutes"] = static_cast<double>(study_.budgetSeconds) / 60;
    }
    for (const std::string& assignment : overridesIn(study_.pipelineText)) {
      page_["overrides"].push_back({{"word", shellWord(assignment)}});
      // The suggested command sets the method itself, so it omits the overrides of `method` and `tradeoff`.
      const bool isInSuggestion = !assignment.starts_with("method") && !assignment.starts_with("tradeoff");
      if (isInSuggestion) page_["kept_overrides"].push_back(page_["overrides"].back());
    }
  }

  void addPictures() {
    for (const ErrorPicture& p : study_.pictures) {
      if (!p.png.empty()) page_["shown_pictures"].push_back({{"caption", p.setting}, {"png", base64(p.png)}});
    }
  }

  // Adds the numbers of beams that hit surfaces of different classes with the two physics.
  void addOtherClasses() {
    for (Json& r : page_["sensing"]) {
      if (r["failure"].get_ref<const std::string&>().empty())
        r["other_class"] = r["both"].get<std::uint64_t>() - r["same_class"].get<std::uint64_t>();
    }
  }

  // Adds a row for each setting, with its figures if it was measured. Rows on a Pareto front are emphasised.
  void addSettings() {
    const std::optional<std::size_t> tracing = tracingDefault(study_);
    const double tracingSeconds = tracing ? study_.settings[*tracing].measured.cost.scanSeconds : 0;
    std::vector<std::size_t> front = frontOf(study_, rangeP99);
    for (const std::size_t i : frontOf(study_, wrongShare)) front.push_back(i);
    page_["settings"] = Json::array();
    for (std::size_t i = 0; i < study_.settings.size(); ++i) {
      const SettingResult& s = study_.settings[i];
      Json row = file_["settings"][i];
      row["argument"] = setArgument(s.setting);
      if (s.failure.empty()) {
        row.update(row["measured"]);
        row["all"] = errorsJson(row["errors"]["all"], s.measured.errors.all);
        const GroupErrors* const away = errorsNamed(s.measured.errors.byEdge, kAwayFromEdges);
        if (away != nullptr && away->range.count > 0) {
          row["away"]["range_m"]["p99"] = away->range.p99;
        }
        row["beams_per_s"] = beamsPerSecond(study_, s);
        const double seconds = s.measured.cost.scanSeconds;
        if (seconds > 0 && tracingSeconds > 0) row["times_tracing"] = seconds / tracingSeconds;
        row["strong"] = std::ranges::find(front, i) != front.end();
      }
      row.erase("measured");
      page_["settings"].push_back(std::move(row));
    }
  }

  // Adds a row for each measured setting: its errors away from edges and at edges.
  void addPlaces() {
    const std::vector<std::string> names = groupNames(study_, measuredSettings(study_), &BeamErrors::byEdge);
    page_["places"] = Json::array();
    for (const std::string& name : names) {
      page_["places"].push_back({{"title", name == kAwayFromEdges ? "away from edges" : "at edges"}});
    }
    for (const std::size_t i : measuredSettings(study_)) {
      Json row{{"name", nameOf(i)}, {"places", Json::array()}};
      for (const std::string& name : names) {
        row["places"].push_back(groupJson(errorsOf(i)["by_place"], errors(i).byEdge, name));
      }
      page_["by_place"].push_back(std::move(row));
    }
  }

  // Adds a row for each class, those with the most beams first, with the errors of the shown settings.
  void addClasses() {
    const std::vector<std::size_t> shown = shownSettings(study_, kMostColumns);
    std::vector<std::pair<std::string, std::uint64_t>> classes;  // class; its beams in the first setting that has any
    for (const std::size_t i : shown) {
      page_["shown"].push_back({{"name", nameOf(i)}});
      for (const ErrorGroup& g : errors(i).byClass) {
        const bool isListed = std::ranges::any_of(classes, [&](const auto& c) { return c.first == g.name; });
        if (!isListed && g.errors.beams > 0) classes.emplace_back(g.name, g.errors.beams);
      }
    }
    std::ranges::stable_sort(classes, [](const auto& a, const auto& b) { return a.second > b.second; });
    for (const auto& [name, beams] : classes) {
      Json row{{"name", name}, {"beams", beams}, {"shown", Json::array()}};
      for (const std::size_t i : shown) {
        row["shown"].push_back(groupJson(errorsOf(i)["by_class"], errors(i).byClass, name));
      }
      page_["classes"].push_back(std::move(row));
    }
  }

  // Adds a table of stages for each method, since methods have different stages. The first columns of a table are the
  // method's stages; the further columns are the stages that all settings have in common.
  void addStages() {
    const auto stageCell = [&](double seconds) {
      if (seconds <= 0) return Json::object();
      return Json{{"stage_s", seconds}, {"stage_beams_per_s", static_cast<double>(study_.beamsPerShot) / seconds}};
    };
    page_["methods"] = Json::array();
    for (const std::string& method : methodsOf(study_)) {
      const std::vector<std::size_t> settings = measuredSettings(study_, method);
      std::vector<std::string> stages;
      for (const std::size_t i : settings) {
        for (const auto& [stage, seconds] : study_.settings[i].measured.cost.stages) {
          if (seconds > 0) appendNew({stage}, stages);
        }
      }
      Json table{{"stages", Json::array()}, {"rows", Json::array()}};
      for (const std::string& stage : stages) {
        table["stages"].push_back({{"title", keyAsWords(stage)}, {"hint", "summed over threads"}});
      }
      for (const auto& [stage, seconds] : study_.commonStages) {
        table["stages"].push_back({{"title", stage + ", one thread"}, {"hint", "the same for all settings"}});
      }
      for (const std::size_t i : settings) {
        const Cost& cost = study_.settings[i].measured.cost;
        Json row{{"name", nameOf(i)}, {"setup_s", cost.setupSeconds}, {"stages", Json::array()}};
        if (cost.scanSeconds > 0) {
          row["scan_s"] = cost.scanSeconds;
          row["beams_per_s"] = beamsPerSecond(study_, study_.settings[i]);
        }
        for (const std::string& stage : stages) {
          row["stages"].push_back(stageCell(cost.stages.contains(stage) ? cost.stages.at(stage) : 0));
        }
        for (const auto& [stage, seconds] : study_.commonStages) row["stages"].push_back(stageCell(seconds));
        table["rows"].push_back(std::move(row));
      }
      page_["methods"].push_back(std::move(table));
    }
  }

  // Adds the advice and all measured settings, each with the command-line argument that selects the setting. Sets
  // `picked` to the argument of the first advised setting or, without advice, of the first measured setting.
  void addUse() {
    for (const Advice& a : advise(study_)) {
      std::string argument;
      for (const SettingResult& s : study_.settings) {
        if (s.setting.name == a.setting) argument = setArgument(s.setting);
      }
      if (!page_.contains("picked") && !argument.empty()) page_["picked"] = argument;
      page_["advice"].push_back({{"need", a.need}, {"setting", a.setting}, {"text", a.text}, {"argument", argument}});
    }
    for (const Json& row : page_["settings"]) {
      if (!row["failure"].get_ref<const std::string&>().empty()) continue;
      page_["assignments"].push_back({{"setting", row["setting"]}, {"argument", row["argument"]}});
      if (!page_.contains("picked")) page_["picked"] = row["argument"];
    }
  }

  const Study& study_;
  const Json file_;
  Json page_;
};

}  // namespace

std::string setArgument(const Setting& setting) {
  return "--set " + shellWord(setting.assignment(), true);
}

std::string studyReport(const Study& study, const std::string& folder) {
  Json values = StudyPage(study).values();
  values["folder_word"] = shellWord(folder);
  return fillPage(kTradeoffTemplate, std::move(values));
}

std::vector<std::string> groupNames(const Study& study, const std::vector<std::size_t>& settings,
                                    GroupsOfErrors groups) {
  std::vector<std::string> names;
  for (const std::size_t i : settings) {
    for (const ErrorGroup& g : study.settings[i].measured.errors.*groups) {
      if (g.errors.beams > 0) appendNew({g.name}, names);
    }
  }
  return names;
}

std::size_t methodColor(const std::string& method) {
  return static_cast<std::size_t>(std::ranges::find(methods(), method, &MethodEntry::name) - methods().begin());
}

std::vector<std::size_t> settingColors(const std::vector<std::string>& settingMethods) {
  const std::size_t methodColors = methods().size();  // methods have the first colours of the palette
  std::vector<std::size_t> colors;
  std::size_t furtherSettings = 0;
  for (auto method = settingMethods.begin(); method != settingMethods.end(); ++method) {
    const bool isFirst = std::find(settingMethods.begin(), method, *method) == method;
    colors.push_back(isFirst ? methodColor(*method) : methodColors + furtherSettings++ % (kChartColors - methodColors));
  }
  return colors;
}

std::vector<std::size_t> shownSettings(const Study& study, std::size_t most) {
  std::vector<std::size_t> shown, fastest;  // `fastest`: the fastest setting of each method
  for (const std::string& method : methodsOf(study)) {
    const std::vector<std::size_t> settings = measuredSettings(study, method);
    if (settings.empty()) continue;
    fastest.push_back(*std::ranges::min_element(
        settings, {}, [&](std::size_t i) { return study.settings[i].measured.cost.scanSeconds; }));
    const auto byDefault =
        std::ranges::find_if(settings, [&](std::size_t i) { return isDefault(study.settings[i].setting); });
    shown.push_back(byDefault != settings.end() ? *byDefault : fastest.back());
  }
  for (const std::vector<std::size_t>& further : {fastest, frontOf(study, rangeP99), frontOf(study, wrongShare)}) {
    std::ranges::copy_if(further, std::back_inserter(shown),
                         [&](std::size_t i) { return std::ranges::find(shown, i) == shown.end(); });
  }
  shown.resize(std::min(shown.size(), most));
  return shown;
}

}  // namespace scanmill
