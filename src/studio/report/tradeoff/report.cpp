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
#include "study/tradeoff/study_figures.h"

namespace scanmill {

namespace {

constexpr std::size_t kMostColumns = 6;

// Returns `errors`, which is the JSON of `e` in tradeoff.json, with derived figures and without empty spreads.
Json errorsJson(Json errors, const GroupErrors& e) {
  for (const char* spread : {"range_m", "intensity", "nearest_to_m", "nearest_from_m"}) {
    if (errors.at(spread).at("count") == 0) errors.erase(spread);
  }
  errors.update({{"labels", e.labels()},
                 {"classes", e.classAgreed()},
                 {"instances", e.instanceAgreed()},
                 {"miss_rate", e.missRate()}});
  if (e.bothHit + e.falseNegatives > 0) errors["false_negative_share"] = falseNegativeShare(e);
  if (e.nearestTo.count + e.nearestFrom.count > 0) errors["hausdorff_m"] = e.hausdorff();
  return errors;
}

// Returns the figures of the group with this name; an empty object if the group has no beams. `groups`: the JSON of the
// groups `own` in tradeoff.json.
Json groupJson(const Json& groups, const std::vector<ErrorGroup>& own, const std::string& name) {
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (own[i].name == name && own[i].errors.beams > 0) return errorsJson(groups[i].at("errors"), own[i].errors);
  }
  return Json::object();
}

// Converts the JSON of tradeoff.json to the values of the page's template.
class StudyPage {
 public:
  explicit StudyPage(const Study& study)
      : study_(study), file_(parseJson(toJson(study), "tradeoff.json")), page_(file_) {}

  Json values() {
    facts();
    settings();
    places();
    classes();
    stages();
    use();
    page_["charts"] = chartValues(studyCharts(study_));
    return std::move(page_);
  }

 private:
  const BeamErrors& errors(std::size_t i) const { return study_.settings[i].measured.errors; }
  const Json& errorsOf(std::size_t i) const { return file_["settings"][i]["measured"]["errors"]; }
  const std::string& nameOf(std::size_t i) const { return study_.settings[i].setting.name; }

  void facts() {
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
      const bool replaced = assignment.starts_with("method") || assignment.starts_with("tradeoff");
      if (!replaced) page_["kept_overrides"].push_back(page_["overrides"].back());
    }
    for (const ErrorPicture& p : study_.pictures) {
      if (p.png.empty()) continue;
      const std::string caption = p.title == p.setting ? p.title : fmt::format("{}: {}", p.setting, p.title);
      page_["shown_pictures"].push_back({{"caption", caption}, {"png", base64(p.png)}});
    }
    for (Json& r : page_["sensing"]) {
      if (r["failure"].get_ref<const std::string&>().empty())
        r["other_class"] = r["both"].get<std::uint64_t>() - r["same_class"].get<std::uint64_t>();
    }
  }

  void settings() {
    const std::optional<std::size_t> base = tracingDefault(study_);
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
        if (const GroupErrors* away = awayFromEdges(s.measured.errors); away != nullptr && away->range.count > 0) {
          row["away"]["range_m"]["p99"] = away->range.p99;
        }
        row["beams_per_s"] = beamsPerSecond(study_, s);
        const double own = s.measured.cost.scanSeconds;
        const double its = base ? study_.settings[*base].measured.cost.scanSeconds : 0;
        if (own > 0 && its > 0) row["times_tracing"] = own / its;
        row["strong"] = std::ranges::find(front, i) != front.end();
      }
      row.erase("measured");
      page_["settings"].push_back(std::move(row));
    }
  }

  void places() {
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

  void classes() {
    const std::vector<std::size_t> shown = shownSettings(study_, kMostColumns);
    std::vector<std::pair<std::string, std::uint64_t>> names;
    for (const std::size_t i : shown) {
      page_["shown"].push_back({{"name", nameOf(i)}});
      for (const ErrorGroup& g : errors(i).byClass) {
        const bool known = std::ranges::any_of(names, [&](const auto& c) { return c.first == g.name; });
        if (!known && g.errors.beams > 0) names.emplace_back(g.name, g.errors.beams);
      }
    }
    std::ranges::stable_sort(names, [](const auto& a, const auto& b) { return a.second > b.second; });
    for (const auto& [name, beams] : names) {
      Json row{{"name", name}, {"beams", beams}, {"shown", Json::array()}};
      for (const std::size_t i : shown) {
        row["shown"].push_back(groupJson(errorsOf(i)["by_class"], errors(i).byClass, name));
      }
      page_["classes"].push_back(std::move(row));
    }
  }

  // Makes a separate table of stages for each method, since methods have different stages.
  void stages() {
    const auto timed = [&](double seconds) {
      if (seconds <= 0) return Json::object();
      return Json{{"stage_s", seconds}, {"stage_beams_per_s", static_cast<double>(study_.beamsPerShot) / seconds}};
    };
    page_["methods"] = Json::array();
    for (const std::string& method : methodsOf(study_)) {
      const std::vector<std::size_t> own = measuredSettings(study_, method);
      std::vector<std::string> names;
      Json table{{"stages", Json::array()}, {"rows", Json::array()}};
      for (const std::size_t i : own) {
        for (const auto& [stage, seconds] : study_.settings[i].measured.cost.stages) {
          if (seconds > 0) appendNew({stage}, names);
        }
      }
      for (const std::string& stage : names) {
        table["stages"].push_back({{"title", keyAsWords(stage)}, {"hint", "summed over threads"}});
      }
      for (const auto& entry : study_.commonStages) {
        table["stages"].push_back({{"title", entry.first + ", one thread"}, {"hint", "the same for all settings"}});
      }
      for (const std::size_t i : own) {
        const Cost& cost = study_.settings[i].measured.cost;
        Json row{{"name", nameOf(i)}, {"setup_s", cost.setupSeconds}, {"stages", Json::array()}};
        if (cost.scanSeconds > 0) {
          row["scan_s"] = cost.scanSeconds;
          row["beams_per_s"] = beamsPerSecond(study_, study_.settings[i]);
        }
        for (const std::string& stage : names) {
          row["stages"].push_back(timed(cost.stages.contains(stage) ? cost.stages.at(stage) : 0));
        }
        for (const auto& entry : study_.commonStages) row["stages"].push_back(timed(entry.second));
        table["rows"].push_back(std::move(row));
      }
      page_["methods"].push_back(std::move(table));
    }
  }

  // Adds the advice, with the command-line arguments that select the recommended settings.
  void use() {
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

std::vector<std::size_t> settingColors(const std::vector<std::string>& ofSettings) {
  const std::size_t ofMethods = methods().size();  // the first colours
  std::vector<std::size_t> colors;
  std::size_t further = 0;
  for (std::size_t k = 0; k < ofSettings.size(); ++k) {
    const auto own = ofSettings.begin() + static_cast<std::ptrdiff_t>(k);
    const bool first = std::find(ofSettings.begin(), own, *own) == own;
    colors.push_back(first ? methodColor(*own) : ofMethods + further++ % (kChartColors - ofMethods));
  }
  return colors;
}

std::vector<std::size_t> shownSettings(const Study& study, std::size_t most) {
  std::vector<std::size_t> shown, fastest;
  const auto show = [&](std::size_t i) {
    if (shown.size() < most && std::ranges::find(shown, i) == shown.end()) shown.push_back(i);
  };
  for (const std::string& method : methodsOf(study)) {
    const std::vector<std::size_t> own = measuredSettings(study, method);
    if (own.empty()) continue;
    fastest.push_back(*std::ranges::min_element(own, [&](std::size_t a, std::size_t b) {
      return study.settings[a].measured.cost.scanSeconds < study.settings[b].measured.cost.scanSeconds;
    }));
    const auto byDefault =
        std::ranges::find_if(own, [&](std::size_t i) { return isDefault(study.settings[i].setting); });
    show(byDefault != own.end() ? *byDefault : fastest.back());
  }
  for (const std::size_t i : fastest) show(i);
  for (const std::size_t i : frontOf(study, rangeP99)) show(i);
  for (const std::size_t i : frontOf(study, wrongShare)) show(i);
  return shown;
}

}  // namespace scanmill
