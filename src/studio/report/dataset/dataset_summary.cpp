#include <fmt/core.h>

#include <algorithm>
#include <set>
#include <utility>

#include "base/append_new.h"
#include "dataset/names.h"
#include "report/dataset/dataset_report.h"
#include "viewer/color_map.h"

namespace scanmill {

namespace {

// Returns the entry with this name; appends an entry with this name if the list has none.
auto& entryNamed(auto& list, const std::string& name) {
  const auto found = std::ranges::find_if(list, [&](const auto& e) { return e.name == name; });
  if (found != list.end()) return *found;
  list.emplace_back().name = name;
  return list.back();
}

// Returns the median; for an even number of values, the mean of the two middle values; 0 if there are none.
double middleOf(std::vector<std::uint64_t> values) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  return static_cast<double>(values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
}

// Returns the name of a sample's sequence; the sample's key if the key names no sequence.
std::string sequenceOf(const SampleRecord& sample) {
  const std::string sequence = partsOfKey(sample.key).sequence;
  return sequence.empty() ? sample.key : sequence;
}

class SummaryMaker {
 public:
  SummaryMaker(const Manifest& manifest, const RangeSteps& steps) : manifest_(manifest) {
    sum_.steps = steps;
    for (const SemanticClass& c : manifest.ontology.classes) addClass(c.id, c.name, c.thing, true);
    for (const SensorRecord& s : manifest.sensors) entryNamed(sum_.sensors, s.name).ranges.assign(steps.count, 0);
  }

  // See summarise().
  DatasetSummary make(const std::vector<ScanIndex>& places, const std::vector<std::optional<ScanCounts>>& counts) {
    addManifest();
    addCounts(places, counts);
    return std::move(sum_);
  }

 private:
  using ObjectKey = std::pair<std::string, std::uint32_t>;  // name of the sequence, instance id

  // Adds the figures that the manifest has for all scans.
  void addManifest() {
    sum_.labelled = manifest_.hasColumn("label");
    sum_.instanced = manifest_.hasColumn("instance");
    sum_.samples = manifest_.samples.size();
    std::map<std::string, std::pair<double, double>> timesOf;  // first and last time of each sequence (s)
    std::map<std::string, std::set<std::string>> splitsOf;
    for (const SampleRecord& sample : manifest_.samples) {
      const std::string name = sequenceOf(sample);
      SequenceSummary& sequence = sequenceEntry(name);
      SplitSummary& split = entryNamed(sum_.splits, sample.split);
      if (splitsOf[name].insert(sample.split).second) {
        sequence.split += (sequence.split.empty() ? "" : ", ") + sample.split;
      }
      ++sequence.samples;
      ++split.samples;
      for (const ScanRecord& scan : sample.scans) {
        auto& [firstTime, lastTime] = timesOf.try_emplace(name, scan.time, scan.time).first->second;
        firstTime = std::min(firstTime, scan.time);
        lastTime = std::max(lastTime, scan.time);
        ++sequence.scans;
        ++split.scans;
        sequence.points += scan.points;
        split.points += scan.points;
        addRecord(sample, scan);
      }
    }
    for (SequenceSummary& s : sum_.sequences) {
      const auto times = timesOf.find(s.name);
      if (times != timesOf.end()) s.seconds = times->second.second - times->second.first;
    }
    for (const ShardRecord& shard : manifest_.shards) {
      SplitSummary& split = entryNamed(sum_.splits, shard.split);
      ++split.shards;
      split.bytes += shard.bytes;
    }
    findScansOfFewPoints();
  }

  // Adds the figures of the scans that were read.
  void addCounts(const std::vector<ScanIndex>& places, const std::vector<std::optional<ScanCounts>>& counts) {
    sum_.scansChosen = places.size();
    for (std::size_t k = 0; k < places.size(); ++k) {
      if (counts[k]) addScan(places[k], *counts[k]);
    }
    for (ClassSummary& c : sum_.classes) c.medianPoints = middleOf(std::move(viewPoints_[c.id]));
    for (const auto& [key, points] : objects_) {
      for (const auto& entry : points) ++classEntry(entry.first).objects;
    }
    findMixedInstances();
  }

  void addClass(std::uint16_t id, const std::string& name, bool thing, bool known) {
    classAt_[id] = sum_.classes.size();
    sum_.classes.push_back({id, name, classColor(&manifest_.ontology, id), thing, known});
    sum_.classes.back().ranges.assign(sum_.steps.count, 0);
  }

  ClassSummary& classEntry(std::uint16_t id) {
    if (!classAt_.contains(id)) addClass(id, fmt::format("class {}", id), false, false);
    return sum_.classes[classAt_.at(id)];
  }

  SequenceSummary& sequenceEntry(const std::string& name) {
    const auto [index, isNew] = sequenceAt_.try_emplace(name, sum_.sequences.size());
    if (isNew) {
      SequenceSummary& sequence = sum_.sequences.emplace_back();
      sequence.name = name;
      const auto record = std::ranges::find(manifest_.sequences, name, &SequenceRecord::name);
      if (record != manifest_.sequences.end()) {
        sequence.scene = record->scene;
        sequence.seed = std::to_string(record->seed);
        sequence.trajectory = record->trajectory;
      }
    }
    return sum_.sequences[index->second];
  }

  // Adds the figures that the manifest states for one scan.
  void addRecord(const SampleRecord& sample, const ScanRecord& scan) {
    const std::string title = fmt::format("{}, {}", sample.key, scan.sensor);
    ++sum_.scans;
    sum_.points += scan.points;
    sum_.beams += scan.beams;
    sum_.unresolved += scan.unresolved;
    SensorSummary& sensor = entryNamed(sum_.sensors, scan.sensor);
    ++sensor.scans;
    sensor.points += scan.points;
    sensor.beams += scan.beams;
    appendNew({scan.method}, sensor.methods);
    for (const auto& [id, points] : scan.pointsPerClass) {
      if (points == 0) continue;
      ClassSummary& c = classEntry(id);
      c.points += points;
      ++c.scans;
      c.pointsOfSplit[sample.split] += points;
    }
    for (const auto& [reason, beams] : scan.beamsPerReason) sensor.beamsPerReason[reason] += beams;
    if (scan.points == 0) sum_.emptyScans.push_back(title);
    if (scan.unresolved > 0) sum_.unresolvedScans.push_back(fmt::format("{}: {} beams", title, scan.unresolved));
    pointsOfSensor_[scan.sensor].push_back(scan.points);
  }

  // Lists scans with few points, compared to other scans of the same sensor. Call addRecord() for all scans before.
  void findScansOfFewPoints() {
    std::map<std::string, double> medians;
    for (const SensorSummary& s : sum_.sensors) medians[s.name] = middleOf(pointsOfSensor_[s.name]);
    for (const SampleRecord& sample : manifest_.samples) {
      for (const ScanRecord& scan : sample.scans) {
        const double median = medians[scan.sensor];
        if (scan.points == 0 || static_cast<double>(scan.points) >= kFewPointsShare * median) continue;
        sum_.fewPoints.push_back(fmt::format("{}, {}: {} points, where the sensor's median is {:.0f}", sample.key,
                                             scan.sensor, scan.points, median));
      }
    }
  }

  // Adds the counts of one scan that was read.
  void addScan(const ScanIndex& index, const ScanCounts& counts) {
    const SampleRecord& sample = manifest_.samples[index.sample];
    SensorSummary& sensor = entryNamed(sum_.sensors, sample.scans[index.scan].sensor);
    ++sum_.scansRead;
    ++sensor.scansRead;
    for (const auto& [id, ranges] : counts.rangesOfClass) {
      addTo(sensor.ranges, ranges);
      if (sum_.labelled) addTo(classEntry(id).ranges, ranges);
    }
    for (const auto& [key, points] : counts.intensities) sensor.intensities[key] += points;
    if (!sum_.labelled) return;
    for (const auto& [id, points] : counts.withoutId) classEntry(id).pointsWithoutId += points;
    const std::string sequence = sequenceOf(sample);
    for (const auto& [instance, pointsOfClass] : counts.instances) {
      const ObjectKey key{sequence, instance};
      for (const auto& [id, points] : pointsOfClass) {
        ++classEntry(id).views;
        viewPoints_[id].push_back(points);
        objects_[key][id] += points;
        sampleShowing_[key].try_emplace(id, index.sample);
      }
    }
  }

  // Finds instances with points of several classes, whose labels are probably wrong. Ignores instances whose classes
  // are usual in one object, such as tree and trunk: most instances with the rarer class also have the other class.
  void findMixedInstances() {
    // A pair of classes is usual if this many instances have both; two suffice if one class never occurs alone.
    constexpr std::uint64_t kFewest = 3;
    std::map<std::uint16_t, std::uint64_t> instancesWith;                     // number of instances with the class
    std::map<std::pair<std::uint16_t, std::uint16_t>, std::uint64_t> shared;  // number of instances with both classes
    for (const auto& [key, points] : objects_) {
      for (auto a = points.begin(); a != points.end(); ++a) {
        ++instancesWith[a->first];
        for (auto b = std::next(a); b != points.end(); ++b) ++shared[{a->first, b->first}];
      }
    }
    for (const auto& [key, points] : objects_) {
      if (points.size() < 2) continue;
      bool isUsual = true;
      for (auto a = points.begin(); a != points.end(); ++a) {
        for (auto b = std::next(a); b != points.end(); ++b) {
          const std::uint64_t both = shared[{a->first, b->first}];
          const std::uint64_t rarer = std::min(instancesWith[a->first], instancesWith[b->first]);
          isUsual = isUsual && ((both >= kFewest && 2 * both > rarer) || (both > 1 && both == rarer));
        }
      }
      if (isUsual) continue;
      const std::uint16_t rarestClass =
          std::ranges::min_element(points, {}, [](const auto& entry) { return entry.second; })->first;
      sum_.mixed.push_back({manifest_.samples[sampleShowing_[key].at(rarestClass)].key, key.second, points});
    }
  }

  const Manifest& manifest_;
  DatasetSummary sum_;
  std::map<std::uint16_t, std::size_t> classAt_;
  std::map<std::string, std::size_t> sequenceAt_;
  std::map<std::string, std::vector<std::uint64_t>> pointsOfSensor_;
  std::map<std::uint16_t, std::vector<std::uint64_t>> viewPoints_;
  std::map<ObjectKey, ClassPoints> objects_;
  // For each object and class, the index of a sample that shows points of the class on the object.
  std::map<ObjectKey, std::map<std::uint16_t, std::size_t>> sampleShowing_;
};

}  // namespace

void addTo(std::vector<std::uint64_t>& sum, const std::vector<std::uint64_t>& part) {
  if (sum.size() < part.size()) sum.resize(part.size(), 0);
  for (std::size_t i = 0; i < part.size(); ++i) sum[i] += part[i];
}

DatasetSummary summarise(const Manifest& manifest, const std::vector<ScanIndex>& places,
                         const std::vector<std::optional<ScanCounts>>& counts, const RangeSteps& steps) {
  return SummaryMaker(manifest, steps).make(places, counts);
}

}  // namespace scanmill
