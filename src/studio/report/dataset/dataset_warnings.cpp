#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "base/short_text.h"
#include "evaluate/spread.h"
#include "report/dataset/dataset_report.h"
#include "study/figure_text.h"

namespace scanmill {

namespace {

constexpr double kFewClassPoints = 1e-4;  // fraction of all points below which a class is reported

// Collects the warnings; each private function adds the warnings about one subject.
class Warnings {
 public:
  Warnings(const DatasetSummary& summary, const ReadingFaults& faults) : sum_(summary), faults_(faults) {}

  std::vector<DatasetWarning> all() {
    reading();
    scans();
    if (sum_.labelled && sum_.points > 0) {
      classes();
      splits();
    }
    instances();
    return std::move(list_);
  }

 private:
  void add(std::string text, std::vector<std::string> places = {}) {
    list_.push_back({std::move(text), std::move(places)});
  }

  std::vector<std::string> classesWhere(const std::function<bool(const ClassSummary&)>& holds) const {
    std::vector<std::string> names;
    for (const ClassSummary& c : sum_.classes) {
      if (holds(c)) names.push_back(c.name);
    }
    return names;
  }

  void reading() {
    if (!faults_.shards.empty()) {
      add(fmt::format("{} missing or damaged. Pictures and figures that need points use only the readable scans.",
                      faults_.shards.size() == 1 ? "1 shard is" : fmt::format("{} shards are", faults_.shards.size())),
          faults_.shards);
    }
    if (!faults_.scans.empty()) {
      add(fmt::format("{} of {} could not be read.", sum_.scansChosen - sum_.scansRead,
                      pluralOf(sum_.scansChosen, "scan")),
          faults_.scans);
    }
    if (!faults_.mistaken.empty()) {
      add("Scans differ from the manifest: `scanmill verify` lists all differences.", faults_.mistaken);
    }
  }

  void scans() {
    if (sum_.samples == 0) add("The dataset has no samples.");
    if (!sum_.emptyScans.empty()) {
      add(fmt::format("{} of {} have no points.", sum_.emptyScans.size(), pluralOf(sum_.scans, "scan")),
          sum_.emptyScans);
    }
    if (!sum_.fewPoints.empty()) {
      add(fmt::format("{} unusually few points: less than half of their sensor's median.",
                      sum_.fewPoints.size() == 1 ? "1 scan has" : fmt::format("{} scans have", sum_.fewPoints.size())),
          sum_.fewPoints);
    }
    if (sum_.unresolved > 0) {
      add(fmt::format("The method gave up {} ({}), so that it is unknown whether they hit.",
                      pluralOf(sum_.unresolved, "beam"), shareText(shareOf(sum_.unresolved, sum_.beams))),
          sum_.unresolvedScans);
    }
  }

  void classes() {
    const auto absent = classesWhere([](const ClassSummary& c) { return c.id != 0 && c.points == 0; });
    if (!absent.empty()) {
      const auto inOntology = classesWhere([](const ClassSummary& c) { return c.id != 0 && c.inOntology; });
      add(fmt::format("No points of {} of the ontology's {} classes: {}.", absent.size(), inOntology.size(),
                      fmt::join(alikeLines(absent), ", ")));
      list_.back().note = true;  // only a note, since few scenes contain all classes
    }
    const auto rare = classesWhere([&](const ClassSummary& c) {
      return c.id != 0 && c.points > 0 && shareOf(c.points, sum_.points) < kFewClassPoints;
    });
    if (!rare.empty()) add(fmt::format("Fewer than 1 in 10,000 points each: {}.", fmt::join(alikeLines(rare), ", ")));
    const auto unknown = classesWhere([](const ClassSummary& c) { return !c.inOntology; });
    if (!unknown.empty())
      add(fmt::format("The ontology does not have these classes: {}.", fmt::join(alikeLines(unknown), ", ")));
    for (const ClassSummary& c : sum_.classes) {
      if (c.id != 0 || c.points <= beamsWithoutSurface()) continue;
      add(fmt::format("{} of the points are unlabelled, in {}.", shareText(shareOf(c.points, sum_.points)),
                      pluralOf(c.scans, "scan")));
    }
  }

  // Returns the number of beams whose reason is a false positive or weather; 0 if the dataset records no reasons. The
  // points of these beams come from no surface and therefore have no class.
  std::uint64_t beamsWithoutSurface() const {
    std::uint64_t beams = 0;
    for (const SensorSummary& sensor : sum_.sensors) {
      for (const auto& [reason, count] : sensor.beamsPerReason) {
        const bool isFromWeather = reason == static_cast<std::uint8_t>(Reason::Weather);
        beams += isFromWeather || reason == static_cast<std::uint8_t>(Reason::FalsePositive) ? count : 0;
      }
    }
    return beams;
  }

  // Warns of classes that the split "train" has and another split lacks, or the other way round.
  void splits() {
    const auto train =
        std::ranges::find_if(sum_.splits, [](const SplitSummary& s) { return s.name == "train" && s.points > 0; });
    if (train == sum_.splits.end()) return;
    const auto warnOfMissing = [&](const std::string& present, const std::string& absent) {
      const auto names = classesWhere([&](const ClassSummary& c) {
        return c.id != 0 && c.pointsOfSplit.contains(present) && !c.pointsOfSplit.contains(absent);
      });
      if (!names.empty())
        add(fmt::format("In {} but not in {}: {}.", present, absent, fmt::join(alikeLines(names), ", ")));
    };
    for (const SplitSummary& other : sum_.splits) {
      if (other.name == train->name || other.points == 0) continue;
      warnOfMissing(train->name, other.name);
      warnOfMissing(other.name, train->name);
    }
  }

  void instances() {
    if (!sum_.instanced || !sum_.labelled) return;
    std::vector<std::string> classesWithoutId;
    for (const ClassSummary& c : sum_.classes) {
      if (c.thing && c.pointsWithoutId > 0)
        classesWithoutId.push_back(fmt::format("{}: {}", c.name, pluralOf(c.pointsWithoutId, "point")));
    }
    if (!classesWithoutId.empty()) add("Points of classes with instances that have no instance id.", classesWithoutId);
    std::vector<std::string> mixed;
    for (const MixedInstance& m : sum_.mixed) {
      std::vector<std::string> parts;
      for (const ClassSummary& c : sum_.classes) {
        const auto points = m.pointsOfClass.find(c.id);
        if (points != m.pointsOfClass.end()) parts.push_back(fmt::format("{} {}", points->second, c.name));
      }
      mixed.push_back(fmt::format("{}, instance {}: {} points", m.sample, m.id, fmt::join(parts, ", ")));
    }
    if (!mixed.empty()) {
      add(fmt::format("{} labels of more than one class that seldom occur in one object: a sign of wrong labels.",
                      mixed.size() == 1 ? "1 instance has" : fmt::format("{} instances have", mixed.size())),
          mixed);
    }
  }

  const DatasetSummary& sum_;
  const ReadingFaults& faults_;
  std::vector<DatasetWarning> list_;
};

}  // namespace

std::vector<std::string> alikeLines(const std::vector<std::string>& lines) {
  std::vector<std::string> firstLines;             // the first line of each form
  std::vector<std::size_t> furtherLines;           // number of further lines of the same form
  std::map<std::string, std::size_t> indexOfForm;  // a form is a line with each number replaced by "#"
  std::set<std::string> differentLines;
  for (const std::string& line : lines) {
    if (!differentLines.insert(line).second) continue;
    std::string form;
    for (const char c : line) {
      const bool isDigit = c >= '0' && c <= '9';
      if (!isDigit || !form.ends_with('#')) form += isDigit ? '#' : c;
    }
    const auto [index, isNew] = indexOfForm.emplace(form, firstLines.size());
    if (isNew) {
      firstLines.push_back(line);
      furtherLines.push_back(0);
    } else {
      ++furtherLines[index->second];
    }
  }
  for (std::size_t i = 0; i < firstLines.size(); ++i) {
    if (furtherLines[i] > 0) firstLines[i] += fmt::format(" and {} alike", furtherLines[i]);
  }
  return firstLines;
}

std::vector<DatasetWarning> warningsOf(const DatasetSummary& summary, const ReadingFaults& faults) {
  return Warnings(summary, faults).all();
}

}  // namespace scanmill
