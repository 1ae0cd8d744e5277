#include "report/tradeoff/report.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <vector>

#include "base/base64.h"
#include "base/short_text.h"
#include "charts/svg_text.h"
#include "pipeline/read/pipeline.h"
#include "report/page/report_html.h"
#include "report/tradeoff/report_charts.h"
#include "report/tradeoff/report_figures.h"
#include "report/tradeoff/report_tables.h"
#include "study/figure_text.h"
#include "study/tradeoff/study.h"
#include "study/tradeoff/study_figures.h"

namespace scanmill {

namespace {

std::string shellWord(const std::string& word) {
  const bool plain = !word.empty() && word.find_first_not_of(
                                          "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
                                          "0123456789_./-=") == std::string::npos;
  if (plain) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

// The pipeline as the user named it; a study that a program made need not know its file.
std::string pipelineWord(const Study& study) {
  return study.pipelineFile.empty() ? "PIPELINE.yaml" : shellWord(study.pipelineFile);
}

std::string command(const Study& study) {
  std::string text = fmt::format("scanmill tradeoff {} -o out/tradeoff", pipelineWord(study));
  if (study.budgetGiven && study.budgetSeconds > 0) {
    text += fmt::format(" --budget {:g}", static_cast<double>(study.budgetSeconds) / 60);
  }
  for (const std::string& assignment : overridesIn(study.pipelineText)) text += " --set " + shellWord(assignment);
  return text;
}

// A dataset of the same pipeline, by a setting.
std::string generateCommand(const Study& study, const Setting& setting) {
  std::string text =
      fmt::format("scanmill generate {} -o {}", pipelineWord(study), shellWord("out/" + study.pipelineName));
  for (const std::string& assignment : overridesIn(study.pipelineText)) {
    const bool replaced = assignment.starts_with("method") || assignment.starts_with("tradeoff");
    if (!replaced) text += " --set " + shellWord(assignment);
  }
  return text + " " + setArgument(setting);
}

// What was measured, as terms and their values.
std::string facts(const Study& study) {
  std::string out;
  const auto fact = [&](const char* name, const std::string& value) {
    if (!value.empty()) out += fmt::format("<dt>{}</dt><dd>{}</dd>\n", name, escapeXml(value));
  };
  const StudyScene& s = study.scene;
  if (!s.key.empty()) {
    fact("Scene", fmt::format("{}, {} triangles{}{}", s.key, amountText(static_cast<double>(s.triangles)),
                              s.frames.empty()       ? ""
                              : s.frames.size() == 1 ? ", scanned at frame "
                                                     : ", scanned at frames ",
                              fmt::join(s.frames, ", ")));
  }
  for (const std::string& sensor : study.sensors) fact("Sensor", sensor);
  if (study.shots > 0) {
    fact("Scans", fmt::format("{} of {} beams, timed at least {}{}", pluralOf(study.shots, "scan"),
                              amountText(static_cast<double>(study.beamsPerShot)),
                              study.repeats == 1 ? "once" : fmt::format("{} times", study.repeats),
                              study.shots == 1 ? "" : " each"));
  }
  const std::size_t measured = measuredSettings(study).size();
  fact("Settings",
       fmt::format("{} measured{}", measured,
                   measured == study.settings.size() ? std::string()
                                                     : fmt::format(", {} not", study.settings.size() - measured)));
  fact("Machine", study.machine.processor.empty()
                      ? std::string()
                      : fmt::format("{}, {}", study.machine.processor,
                                    pluralOf(static_cast<std::uint64_t>(study.machine.threads), "thread")));
  fact("OpenGL", study.machine.renderer);
  fact("Date",
       fmt::format("{}{}", study.date, study.seconds > 0 ? fmt::format(", in {}", shortTime(study.seconds)) : ""));
  fact("Program", study.programVersion.empty() ? "" : "Scanmill " + study.programVersion);
  out += fmt::format("<dt>Command</dt><dd><code>{}</code></dd>\n", escapeXml(command(study)));
  return fmt::format("<dl class=\"facts\">\n{}</dl>\n", out);
}

std::string recommendation(const Study& study) {
  std::string cards;
  for (const Advice& a : advise(study)) {
    std::string use;
    for (const SettingResult& s : study.settings) {
      if (s.setting.name == a.setting) use = fmt::format("<p><code>{}</code></p>\n", escapeXml(setArgument(s.setting)));
    }
    cards += fmt::format("<div class=\"card{}\"><p class=\"need\">{}</p>\n{}{}{}</div>\n",
                         a.setting.empty() ? " none" : "", escapeXml(a.setting.empty() ? a.need : a.need + ":"),
                         a.setting.empty() ? "" : fmt::format("<h3>{}</h3>\n", escapeXml(a.setting)),
                         htmlParagraph(a.text), use);
  }
  return cards.empty() ? "" : fmt::format("<div class=\"cards\">\n{}</div>\n", cards);
}

std::string details(const std::string& summary, const std::string& body) {
  return body.empty() ? "" : fmt::format("<details><summary>{}</summary>\n{}</details>\n", escapeXml(summary), body);
}

// A heading for an empty chart helps nobody.
std::string figuresIf(bool any, const std::vector<std::string>& svgs) {
  return any ? htmlFigures(svgs) : "";
}

std::string pictures(const Study& study) {
  std::string out;
  for (const ErrorPicture& p : study.pictures) {
    if (p.png.empty()) continue;
    const std::string caption = escapeXml(p.title == p.setting ? p.title : fmt::format("{}: {}", p.setting, p.title));
    out += fmt::format(
        "<figure class=\"picture\"><img src=\"data:image/png;base64,{0}\" alt=\"{1}\">"
        "<figcaption>{1}</figcaption></figure>\n",
        base64(p.png), caption);
  }
  return out.empty() ? "" : fmt::format("<div class=\"figures\">\n{}</div>\n", out);
}

std::string leftOut(const Study& study) {
  std::string items;
  for (const std::string& line : study.left) items += fmt::format("<li>{}</li>\n", escapeXml(line));
  return items.empty() ? "" : fmt::format("<ul>\n{}</ul>\n", items);
}

std::string again(const Study& study) {
  std::string out = htmlCode(command(study));
  const std::vector<std::size_t> measured = measuredSettings(study);
  if (!measured.empty()) {
    const std::vector<Advice> advice = advise(study);
    const auto named = std::find_if(advice.begin(), advice.end(), [](const Advice& a) { return !a.setting.empty(); });
    const Setting* picked = &study.settings[measured.front()].setting;
    for (const std::size_t i : measured) {
      if (named != advice.end() && study.settings[i].setting.name == named->setting)
        picked = &study.settings[i].setting;
    }
    out +=
        htmlParagraph("To use a setting, put what follows `method=` into the pipeline as `method:`, or say it once:");
    out += htmlCode(generateCommand(study, *picked));
    out += htmlParagraph(
        "To have the cheapest one that is good enough chosen, on a sample of the pipeline's own scans, ask for it "
        "there:");
    out += htmlCode("method: {auto: {max_error: {p99: 2cm, miss_rate: 0.1%, labels: 99.5%}}}");
    out += details("How to use each setting", assignmentsTable(study));
  }
  if (!study.pipelineText.empty()) out += details("The pipeline", htmlCode(study.pipelineText));
  return out;
}

}  // namespace

std::string studyReport(const Study& study) {
  const bool any = !measuredSettings(study).empty();
  const std::string alone = study.sensing.empty() ? ""
                                                  : " Every beam is one ray that ends at the first surface, whatever "
                                                    "the pipeline's effects: what footprint, glass and weather change "
                                                    "stands further down.";
  std::vector<HtmlSection> sections;
  sections.push_back(
      {"advice", "Which setting to take",
       "Ratios hold on this scene, this sensor and this machine; errors are against ray tracing in double "
       "precision, beam by beam." +
           alone,
       recommendation(study)});
  sections.push_back(
      {"speed", "Speed against error",
       "A mark is a setting. To the right is faster, down is better; the staircase is what can be had, without steps "
       "of less than 5 % in time, which are noise. Range errors below 10 \xC2\xB5m count as exact: single precision "
       "resolves no more at 100 m.",
       figuresIf(any, {rangeFrontChart(study)}) + figuresIf(any, {wrongFrontChart(study)})});
  sections.push_back({"settings", "All settings",
                      "Click a heading to sort. Rows with a coloured ground lie on a front of one of the charts above; "
                      "point at a name or a figure for more.",
                      settingsTable(study), true});
  sections.push_back({"range", "Error against range and incidence",
                      "Each method with its defaults and at its fastest, or settings on the fronts above. Gaps: too "
                      "little was hit there. In the last row, the nearest point may be of any band and any beam.",
                      htmlFigures({rangeErrorByRange(study), rangeErrorByIncidence(study), wrongByRange(study),
                                   wrongByIncidence(study), nearestByRange(study), nearestByIncidence(study)})});
  sections.push_back(
      {"edges", "At edges and away from edges",
       "A beam lies at an edge where its neighbours meet another thing, or the range steps.",
       htmlFigures({rangeErrorByPlace(study), wrongByPlace(study)}) + details("The figures", placesTable(study))});
  sections.push_back(
      {"classes", "Classes",
       "The most frequent first. A beam belongs to the class that it hits in truth, or, where in truth it "
       "hits nothing, to the one that the setting hits. False negatives: only the truth hits; false "
       "positives: only the setting does.",
       htmlFigures({wrongByClass(study), falseNegativesByClass(study)}) + details("The figures", classesTable(study))});
  sections.push_back(
      {"things", "Thin and small things", "", htmlFigures({recallByThickness(study), recallByLength(study)})});
  sections.push_back({"stages", "Stages",
                      "In the tables, a method's own stages are summed over the threads that work on them; effects and "
                      "encoding were timed on one thread and take the same whatever the setting.",
                      figuresIf(any, {stagesChart(study)}) + stagesTables(study)});
  sections.push_back({"encodings", "Encodings",
                      "Encoding is part of the trade: what a scan takes on disk, and what it loses.",
                      htmlFigures({encodingsChart(study)}) + encodingsTable(study)});
  sections.push_back({"sensing", "Footprint, glass and weather",
                      "What leaving parts of the sensor's physics out costs: the nearest return of each beam against "
                      "the truth in the first row, by ray tracing, without the noise of ranges and angles.",
                      sensingTable(study)});
  sections.push_back({"rings", "Rings", "What a scan costs whatever its size, and what each ring adds.",
                      htmlFigures({ringsChart(study)}) + ringsTable(study)});
  sections.push_back({"pictures", "Where beams err",
                      "The scan's points, coloured by their error. Click a picture to enlarge it.", pictures(study)});
  sections.push_back({"left", "What was left out", "", leftOut(study)});
  sections.push_back({"again", "Again, and in a pipeline", "", again(study)});
  std::string head =
      htmlParagraph("Each way of making a scan, measured on one scene: what it takes, and how it errs.", "lead");
  if (study.settings.empty()) head += htmlParagraph("No setting was measured.");
  return htmlPage("Speed against accuracy: " + study.pipelineName, head + facts(study), sections);
}

}  // namespace scanmill
