#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <string_view>

#include "base/hash.h"
#include "dataset/card.h"
#include "report/dataset/dataset_report.h"
#include "report/dataset/scan_view.h"
#include "report/page/page.h"
#include "scan/columns.h"

namespace scanmill {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ClassSummary, name, id, points, scans, thing, objects, views, medianPoints,
                                   pointsWithoutId)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SequenceSummary, name, scene, seed, trajectory, split, samples, scans, points,
                                   seconds)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SplitSummary, name, samples, scans, points, shards, bytes)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ShardRecord, file, split, samples, bytes, sha256)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FormatRecord, name, suffix, maxErrorMetres)

namespace {

constexpr std::size_t kMostRows = 2000;   // maximum number of rows in a table; browsers are slow with more
constexpr std::size_t kMostPlaces = 200;  // maximum number of lines below a warning

// Returns the unit and the meaning of a column; an empty text for unknown columns.
std::string meaningOf(const std::string& name) {
  const std::size_t axis = std::string_view("xyz").find(name);
  if (name.size() == 1 && axis < 3) {
    return fmt::format("m, sensor frame: {}", std::array{"forward", "left", "up"}[axis]);
  }
  const std::size_t index = columnIndex(name);
  if (index == kColumnCount) return "";
  const Column& column = kColumns[index];
  return fmt::format("{}{}{}", column.unit, column.unit.empty() ? "" : ", ", column.meaning);
}

// Computes the values for the template dataset.html.
class DatasetPage {
 public:
  explicit DatasetPage(const DatasetReport& report)
      : report_(report), manifest_(report.manifest), summary_(report.summary) {}

  Json values() {
    facts();
    warnings();
    pictures();
    classes();
    objects();
    reasons();
    sensors();
    scenes();
    filesAndColumns();
    page_["charts"] = chartValues(datasetCharts(manifest_, summary_));
    return std::move(page_);
  }

 private:
  // Sets the values that describe the dataset as a whole.
  void facts() {
    const std::string& folder = report_.folder;
    std::uint64_t bytes = 0;
    for (const ShardRecord& shard : manifest_.shards) bytes += shard.bytes;
    const auto hasSamples = [&](const char* split) {
      return std::ranges::any_of(summary_.splits,
                                 [&](const SplitSummary& s) { return s.name == split && s.samples > 0; });
    };
    std::set<std::string> methods;
    for (const SensorSummary& s : summary_.sensors) methods.insert(s.methods.begin(), s.methods.end());
    std::vector<std::string> modelledLines;
    for (const ModelledItem& item : manifest_.modelled) modelledLines.push_back(lineOf(item));
    page_ = {
        {"title", "Dataset " + (folder.empty() || folder == manifest_.name ? manifest_.name
                                                                           : manifest_.name + " (" + folder + ")")},
        {"samples", summary_.samples},
        {"several_splits", summary_.splits.size() > 1},
        {"scans", summary_.scans},
        {"points", summary_.points},
        {"beams", summary_.beams},
        {"bytes", bytes},
        {"shard_count", manifest_.shards.size()},
        {"methods", methods},
        {"organised", manifest_.organised},
        {"deskewed", manifest_.deskewed},
        {"ontology", {{"name", manifest_.ontology.name}, {"source", manifest_.ontology.source}}},
        {"program", manifest_.programVersion},
        {"seed", manifest_.seed},
        {"all_read", summary_.scansRead == summary_.scans},
        {"chosen_few", summary_.scansChosen < summary_.scans},
        {"scans_read", summary_.scansRead},
        {"labelled", summary_.labelled},
        {"validated", hasSamples("train") && hasSamples("val")},
        {"path", shellWord(report_.path)},
        {"first_sample", manifest_.samples.empty() ? "" : shellWord(manifest_.samples.front().key)},
        {"view", report_.view},
        {"picture_seed", report_.seed},
        {"hashed", report_.hashed},
        {"modelled", alikeLines(modelledLines)},
        {"pipeline_sha256", manifest_.pipelineSha256},
        {"pipeline_text", manifest_.pipelineText}};
    for (const SplitSummary& s : summary_.splits)
      page_["split_texts"].push_back(fmt::format("{} {}", s.name, s.samples));
    for (const SensorRecord& r : manifest_.sensors) {
      page_["sensor_texts"].push_back(fmt::format("{} ({})", r.name, r.beams.model));
    }
  }

  // Adds the warnings and the notes, each with at most kMostPlaces of the affected samples, instances or shards.
  void warnings() {
    for (const DatasetWarning& w : report_.warnings) {
      Json remark{{"text", w.text}};
      if (w.places.size() == 1) {
        remark["place"] = w.places.front();
      } else if (!w.places.empty()) {
        const std::size_t shown = std::min(w.places.size(), kMostPlaces);
        remark["places"] = std::vector<std::string>(w.places.begin(), w.places.begin() + static_cast<long>(shown));
        remark["more_places"] = w.places.size() - shown;
      }
      Json& card = page_[w.note ? "notes" : "warnings"];
      card["remarks"].push_back(std::move(remark));
      card["count"] = card["remarks"].size();
    }
  }

  // Adds the pictures of scans and the images of reasons as PNG files in base64.
  void pictures() {
    for (const PicturedScan& scan : report_.pictured) {
      for (const auto& [color, png] : scan.pictures) {
        page_["pictured"].push_back(
            {{"caption", fmt::format("{} ({}), by {}", scan.title, scan.split, color)}, {"png", base64(png)}});
      }
    }
    for (const PicturedScan& scan : report_.reasonImages) {
      page_["reason_images"].push_back(
          {{"caption", fmt::format("{} ({}), a row per ring and a column per column", scan.title, scan.split)},
           {"png", base64(scan.pictures.front().second)}});
    }
  }

  // Adds a row for each class with points. The table has a group of columns for each item of `class_splits` and of
  // `instance_columns`; `instance_columns` has one item if the dataset has instances and labels, otherwise none.
  void classes() {
    page_["all_points"] = summary_.points;
    page_["class_splits"] = page_["instance_columns"] = page_["classes"] = Json::array();
    for (const SplitSummary& s : summary_.splits) {
      if (s.samples > 0 && summary_.splits.size() > 1) page_["class_splits"].push_back({{"name", s.name}});
    }
    if (summary_.instanced && summary_.labelled) page_["instance_columns"].push_back(Json::object());
    for (const ClassSummary& c : summary_.classes) {
      if (c.points == 0) continue;
      Json row = c;
      row["class_splits"] = Json::array();
      for (const Json& split : page_["class_splits"]) {
        const auto points = c.pointsOfSplit.find(split["name"]);
        row["class_splits"].push_back({{"points", points == c.pointsOfSplit.end() ? 0 : points->second}});
      }
      if (!c.thing && c.objects == 0) row["objects"] = row["views"] = nullptr;
      if (c.views == 0) row["medianPoints"] = nullptr;
      row["instance_columns"] = page_["instance_columns"];
      page_["classes"].push_back(std::move(row));
    }
  }

  static Json visibilityRow(const std::string& name, const VisibilityCounts& views) {
    Json row{{"name", name}, {"views", std::accumulate(views.begin(), views.end(), std::uint64_t{0})}};
    for (const std::uint64_t count : views) row["visibility"].push_back({{"part", count}});
    return row;
  }

  // Adds two tables of the objects' views by visibility: for each class and for each band of distance.
  void objects() {
    if (report_.objects.ofClass.empty()) return;
    page_["object_samples"] = report_.objects.samples;
    for (const char* step : kVisibilitySteps) page_["visibility"].push_back({{"title", step}});
    Json classRows = Json::array(), distanceRows = Json::array();
    for (const auto& [id, views] : report_.objects.ofClass) {
      classRows.push_back(visibilityRow(manifest_.ontology.find(id)->name, views));
    }
    for (std::size_t i = 0; i <= kDistanceSteps.size(); ++i) {
      const double low = i == 0 ? 0 : kDistanceSteps[i - 1];
      const std::string name =
          i < kDistanceSteps.size() ? fmt::format("{} to {} m", low, kDistanceSteps[i]) : fmt::format("from {} m", low);
      distanceRows.push_back(visibilityRow(name, report_.objects.ofDistance[i]));
    }
    for (Json* rows : {&classRows, &distanceRows}) {
      std::erase_if(rows->get_ref<Json::array_t&>(), [](const Json& row) { return row["views"] == 0; });
    }
    page_["objects"] = {{{"by", "class"}, {"rows", classRows}}, {{"by", "distance"}, {"rows", distanceRows}}};
  }

  // Adds a row for each reason that occurs, with the number of beams of each sensor that records reasons.
  void reasons() {
    for (const SensorSummary& s : summary_.sensors) {
      if (!s.beamsPerReason.empty()) page_["reason_sensors"].push_back({{"name", s.name}});
    }
    for (const ReasonEntry& r : scanmill::reasons()) {
      Json row{{"name", r.name}, {"color", htmlColor(r.color)}, {"meaning", r.meaning}};
      std::uint64_t beamsOfAllSensors = 0;
      for (const SensorSummary& s : summary_.sensors) {
        if (s.beamsPerReason.empty()) continue;
        std::uint64_t allBeams = 0;
        for (const auto& [reason, beams] : s.beamsPerReason) allBeams += beams;
        const auto found = s.beamsPerReason.find(static_cast<std::uint8_t>(r.reason));
        const std::uint64_t beams = found == s.beamsPerReason.end() ? 0 : found->second;
        row["reason_sensors"].push_back({{"beams", beams}, {"all_beams", allBeams}});
        beamsOfAllSensors += beams;
      }
      if (beamsOfAllSensors > 0) page_["reasons"].push_back(std::move(row));
    }
  }

  // Adds a row for each sensor of the manifest: angles in degrees, and the span of each mount value over all samples.
  void sensors() {
    for (std::size_t i = 0; i < manifest_.sensors.size(); ++i) {
      const SensorRecord& sensor = manifest_.sensors[i];
      const SensorSummary& counts = summary_.sensors[i];  // summary_.sensors begins with the manifest's sensors
      const BeamTable& beams = sensor.beams;
      const MountSpans mount = mountSpans(manifest_, sensor);
      Json row{{"name", sensor.name},           {"model", beams.model},          {"rings", beams.rings},
               {"columns", beams.columns},      {"least_range", beams.minRange}, {"most_range", beams.maxRange},
               {"field", degrees(beams.field)}, {"period", beams.period},        {"x", spanText(mount[0])},
               {"y", spanText(mount[1])},       {"z", spanText(mount[2])},       {"yaw", spanText(mount[3])},
               {"pitch", spanText(mount[4])},   {"roll", spanText(mount[5])},    {"own_methods", counts.methods},
               {"scans", counts.scans},         {"points", counts.points},       {"beams", counts.beams},
               {"source", beams.source}};
      if (!beams.elevation.empty()) {
        const auto [lowest, highest] = std::ranges::minmax(beams.elevation);
        row.update({{"lowest", degrees(lowest)}, {"highest", degrees(highest)}});
      }
      page_["sensors"].push_back(std::move(row));
    }
  }

  void scenes() {
    page_["all_samples"] = summary_.samples;
    page_["splits"] = summary_.splits;
    addRows("sequences", summary_.sequences);
  }

  // Adds the first kMostRows of the rows as `name`, and the number of the remaining rows as `more_name`.
  void addRows(const char* name, const auto& rows) {
    page_[name] = Json::array();
    for (std::size_t i = 0; i < std::min(rows.size(), kMostRows); ++i) page_[name].push_back(rows[i]);
    page_[std::string("more_") + name] = rows.size() - page_[name].size();
  }

  void filesAndColumns() {
    constexpr std::size_t kHashShown = 12;
    addRows("shards", manifest_.shards);
    for (std::size_t i = 0; i < page_["shards"].size(); ++i) {
      page_["shards"][i].update(
          {{"sha256_begin", manifest_.shards[i].sha256.substr(0, kHashShown)}, {"fault", report_.shardFaults[i]}});
    }
    for (const std::string& c : manifest_.columns) page_["columns"].push_back({{"name", c}, {"meaning", meaningOf(c)}});
    page_["formats"] = manifest_.formats;
  }

  const DatasetReport& report_;
  const Manifest& manifest_;
  const DatasetSummary& summary_;
  Json page_;
};

}  // namespace

std::string datasetPage(const DatasetReport& report) {
  PageExtras extras{.css = std::string(kDatasetStyle)};
  if (!report.view.empty()) {
    extras.css += kScanViewStyle;
    extras.scripts = {std::string(kThreeScript), std::string(kOrbitScript), std::string(kScanViewScript)};
  }
  return fillPage(kDatasetTemplate, DatasetPage(report).values(), extras);
}

}  // namespace scanmill
