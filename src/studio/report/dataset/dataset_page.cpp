#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string_view>

#include "base/base64.h"
#include "base/short_text.h"
#include "charts/svg_text.h"
#include "report/dataset/dataset_charts.h"
#include "report/dataset/dataset_report.h"
#include "report/dataset/dataset_tables.h"
#include "report/dataset/scan_view.h"
#include "report/page/report_html.h"
#include "study/figure_text.h"

namespace scanmill {

namespace {

constexpr const char* kWarningCss = R"(
.card.warn,.card.notes{margin:14px 0}
.card.warn{border-left-color:var(--bad)}
.card.warn h2,.card.notes h2{margin:0 0 4px;font-size:16px}.card.warn h2{color:var(--bad)}
.card.warn li,.card.notes li{margin:3px 0}.card.warn details,.card.notes details{margin:2px 0}
.card.warn pre,.card.notes pre{max-height:40vh;overflow:auto}
)";

std::string listOf(const std::vector<std::string>& lines) {
  std::string items;
  for (const std::string& line : lines) items += fmt::format("<li>{}</li>\n", escapeXml(line));
  return items.empty() ? "" : fmt::format("<ul>\n{}</ul>\n", items);
}

// The first of them are enough to find the cause.
std::string placesOf(const DatasetWarning& warning) {
  constexpr std::size_t kMost = 200;
  std::string text;
  for (std::size_t i = 0; i < std::min(warning.places.size(), kMost); ++i) text += warning.places[i] + "\n";
  if (warning.places.size() > kMost) text += fmt::format("... and {} more\n", warning.places.size() - kMost);
  if (warning.places.size() == 1) return fmt::format("<br><code>{}</code>", escapeXml(warning.places.front()));
  return text.empty() ? "" : htmlDetails("Where", htmlCode(text));
}

std::string remarks(const DatasetReport& report, bool notes) {
  std::string items;
  std::size_t count = 0;
  for (const DatasetWarning& w : report.warnings) {
    if (w.note != notes) continue;
    const std::string command = w.command.empty() ? "" : fmt::format("<code>{}</code>", escapeXml(w.command));
    items += fmt::format("<li>{}{}{}</li>\n", escapeXml(w.text), placesOf(w), command);
    ++count;
  }
  if (count == 0) return "";
  return fmt::format("<div class=\"card {}\" id=\"{}\">\n<h2>{}</h2>\n<ul>\n{}</ul>\n</div>\n",
                     notes ? "notes" : "warn", notes ? "notes" : "warnings",
                     pluralOf(count, notes ? "note" : "warning"), items);
}

// Methods tell these of every scene and seed; equal lines are there once. Where all differ, each is told whose it is:
// they stand in the scenes' order.
std::vector<std::string> modelledLines(const DatasetReport& report) {
  constexpr std::array<std::string_view, 3> kOfScenes{"instancing", "alpha cut-outs", "reflectance textures"};
  std::vector<std::string> scenes;
  for (const SequenceSummary& s : report.summary.sequences) {
    const std::string scene = fmt::format("{}, seed {}", s.scene, s.seed);
    if (s.scene.empty()) return report.manifest.modelled;
    if (std::find(scenes.begin(), scenes.end(), scene) == scenes.end()) scenes.push_back(scene);
  }
  const auto topicOf = [](const std::string& line) { return line.substr(0, line.find(": ")); };
  std::map<std::string, std::size_t> lines, next;
  for (const std::string& line : report.manifest.modelled) ++lines[topicOf(line)];
  std::vector<std::string> named;
  for (const std::string& line : report.manifest.modelled) {
    const std::string topic = topicOf(line);
    const bool ofScenes = lines[topic] > 1 && lines[topic] == scenes.size() &&
                          std::find(kOfScenes.begin(), kOfScenes.end(), topic) != kOfScenes.end();
    named.push_back(ofScenes ? fmt::format("{} ({})", line, scenes[next[topic]++]) : line);
  }
  return named;
}

std::string titleOf(const DatasetReport& report) {
  const std::string& name = report.manifest.name;
  return "Dataset " + (report.folder.empty() || report.folder == name ? name : name + " (" + report.folder + ")");
}

std::string facts(const DatasetReport& report) {
  const Manifest& m = report.manifest;
  const DatasetSummary& s = report.summary;
  std::string out;
  const auto fact = [&](const char* name, const std::string& value) {
    if (!value.empty()) out += fmt::format("<dt>{}</dt><dd>{}</dd>\n", name, escapeXml(value));
  };
  std::uint64_t bytes = 0;
  for (const ShardRecord& shard : m.shards) bytes += shard.bytes;
  std::vector<std::string> splits, sensors;
  std::set<std::string> methods;
  for (const SplitSummary& split : s.splits) splits.push_back(fmt::format("{} {}", split.name, split.samples));
  for (const SensorRecord& r : m.sensors) sensors.push_back(fmt::format("{} ({})", r.name, r.beams.model));
  for (const SensorSummary& r : s.sensors) methods.insert(r.methods.begin(), r.methods.end());
  const double hits = s.beams == 0 ? 0 : static_cast<double>(s.points) / static_cast<double>(s.beams);
  fact("Samples", fmt::format("{}{}", s.samples,
                              splits.size() > 1 ? fmt::format(": {}", fmt::join(splits, ", ")) : std::string()));
  fact("Scans", fmt::format("{}, {} points of {} beams ({})", s.scans, amountText(static_cast<double>(s.points)),
                            amountText(static_cast<double>(s.beams)), shareText(hits)));
  fact("Size", fmt::format("{} in {}", shortBytes(static_cast<double>(bytes)), pluralOf(m.shards.size(), "shard")));
  fact("Sensors", fmt::format("{}", fmt::join(sensors, ", ")));
  fact("Method", fmt::format("{}", fmt::join(methods, ", ")));
  if (m.chosen) fact("Chosen", fmt::format("{}: {}", m.chosen->setting, m.chosen->why));
  fact(
      "Layout",
      fmt::format("{}{}", m.organised ? "organised: misses are kept, without a position" : "dense: misses are left out",
                  m.deskewed ? "; deskewed" : ""));
  fact("Classes", fmt::format("ontology {}{}", m.ontology.name,
                              m.ontology.source.empty() ? "" : fmt::format(" ({})", m.ontology.source)));
  fact("Made by", fmt::format("Scanmill {}, seed {}", m.programVersion, m.seed));
  fact("Read for this page",
       s.scansRead == s.scans
           ? std::string("all scans")
           : fmt::format("{} of {}{}", s.scansRead, pluralOf(s.scans, "scan"),
                         s.scansChosen < s.scans ? ", spread evenly; what needs points is of these" : ""));
  return fmt::format("<dl class=\"facts\">\n{}</dl>\n", out);
}

// As high as wide pixels make them legible.
std::string reasonImages(const DatasetReport& report) {
  std::string out;
  for (const PicturedScan& scan : report.reasonImages) {
    const std::string caption =
        escapeXml(fmt::format("{} ({}), a row per ring and a column per column", scan.title, scan.split));
    out += fmt::format(
        "<figure class=\"picture\"><img style=\"width:100%;height:220px;image-rendering:pixelated\" "
        "src=\"data:image/png;base64,{0}\" alt=\"{1}\"><figcaption>{1}</figcaption></figure>\n",
        base64(scan.pictures.front().second), caption);
  }
  return out;
}

std::string pictures(const DatasetReport& report) {
  std::string out;
  for (const PicturedScan& scan : report.pictured) {
    for (const auto& [color, png] : scan.pictures) {
      const std::string caption = escapeXml(fmt::format("{} ({}), by {}", scan.title, scan.split, color));
      out += fmt::format(
          "<figure class=\"picture\"><img src=\"data:image/png;base64,{0}\" alt=\"{1}\">"
          "<figcaption>{1}</figcaption></figure>\n",
          base64(png), caption);
    }
  }
  return out.empty() ? "" : fmt::format("<div class=\"figures\">\n{}</div>\n", out);
}

}  // namespace

std::string datasetPage(const DatasetReport& report) {
  const Manifest& m = report.manifest;
  const DatasetSummary& s = report.summary;
  const std::string read =
      s.scansRead == s.scans ? "All scans were read." : fmt::format("{} of {} scans were read.", s.scansRead, s.scans);
  std::vector<HtmlSection> sections;
  sections.push_back({"pictures", "Pictures",
                      fmt::format("Random samples (seed {}), from behind and above the sensor. Click a picture to "
                                  "enlarge it.",
                                  report.seed),
                      pictures(report)});
  sections.push_back({"view", "In 3D", "The same scans, in the sensor's frame: x forward, y left, z up.", report.view});
  sections.push_back(
      {"classes", "Classes",
       s.labelled ? "Points and scans are of the whole dataset; classes without points are left out. " + read : "",
       s.labelled ? htmlFigures({classPointsChart(s), splitSharesChart(s), classObjectsChart(s)}) + classesOverview(s)
                  : htmlParagraph("The scans have no class labels."),
       true});
  const std::string mixed = mixedInstances(s);
  sections.push_back(
      {"instances", "Instances of several classes",
       "Things may have parts of different classes. These combinations are common here, hence no warning; "
       "instances with rarer ones are listed at the top of the page.",
       mixed});
  sections.push_back(
      {"objects", "How much is seen of objects",
       fmt::format("Every object that the range of a sensor reaches, in {}: whether the scan has points of "
                   "it, and how many of the beams that would meet it nothing else blocks.",
                   pluralOf(report.objects.samples, "sample")),
       objectsOverview(m, report.objects), true});
  sections.push_back({"distances", "Distances and intensities", read,
                      htmlFigures({ringPointsChart(s), ringSharesChart(s), rangesChart(s), intensitiesChart(s)}) +
                          htmlDetails("The figures of the rings", distancesOverview(s))});
  sections.push_back({"reasons", "For every beam a reason",
                      "What the nearest return of each beam comes from, or why it has none; of all scans.",
                      reasonsOverview(s) + reasonImages(report), true});
  sections.push_back({"sensors", "Sensors", "", sensorsOverview(m, s) + htmlFigures({scanPointsChart(m)}), true});
  sections.push_back({"sequences", "Scenes and sequences",
                      "A sequence is one scene with one seed, driven along one trajectory; whole sequences share a "
                      "split.",
                      sequencesOverview(s), true});
  sections.push_back({"splits", "Splits", "", splitsOverview(s)});
  sections.push_back({"shards", "Shards",
                      report.hashed ? "Sizes and SHA-256 were compared with the manifest's."
                                    : "Sizes were compared with the manifest's; `scanmill verify` compares the bytes.",
                      shardsOverview(m, report.shardFaults), true});
  sections.push_back({"format", "Columns and formats", "", columnsOverview(m) + formatsOverview(m)});
  sections.push_back({"modelled", "What was modelled", "", listOf(modelledLines(report))});
  sections.push_back({"pipeline", "Pipeline", "",
                      htmlParagraph("SHA-256 " + m.pipelineSha256, "small") +
                          htmlDetails("The pipeline's text, overrides as comments", htmlCode(m.pipelineText))});
  HtmlExtras extras;
  if (!report.view.empty()) extras = scanViewExtras();
  extras.css += kWarningCss;
  return htmlPage(titleOf(report), remarks(report, false) + remarks(report, true) + facts(report), sections, extras);
}

}  // namespace scanmill
