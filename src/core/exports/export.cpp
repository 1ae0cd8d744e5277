#include "exports/export.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/folder_lock.h"
#include "base/hash.h"
#include "base/own_folder.h"
#include "base/parallel.h"
#include "config/resources.h"
#include "config/version.h"
#include "dataset/card.h"
#include "dataset/json_text.h"
#include "dataset/names.h"
#include "dataset/scan_store.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

constexpr const char* kRecord = "scanmill_export.json";       // description of a complete export
constexpr const char* kUnfinished = ".scanmill_export.json";  // description of an unfinished export
constexpr const char* kLock = ".scanmill_export.lock";

// A unit of work: the frames [firstFrame, firstFrame + frames) of a sequence, which are one frame or all frames.
struct Unit {
  std::size_t sequence = 0;
  std::size_t firstFrame = 0;
  std::size_t frames = 1;
};

// The constructor chooses the sensors, sequences and classes to export; run() checks the samples and writes the files.
class Export {
 public:
  explicit Export(const ExportOptions& options)
      : options_(options),
        layout_(options.layout->make()),
        store_(options.dataset, ScanStore::Digests::Compared),
        folder_(options.folder) {
    if (store_.manifest() == nullptr || store_.folder() != options.dataset) {
      throw InputError({options.dataset.string()}, "is not the folder of a dataset: export reads complete datasets");
    }
    if (isWithin(options.folder, options.dataset)) {
      throw InputError({options.folder.string()}, "is within the dataset's folder: name another folder with -o");
    }
    plan_.dataset = options.dataset;
    plan_.manifest = *store_.manifest();
    plan_.ros = options.ros;
    chooseClasses();
    chooseSensors();
    chooseSequences();
    if (!options_.layout->revolutions) requireOneRevolution();
    layout_->check(plan_);
  }

  ExportSummary run() {
    checkFolder();
    std::vector<Unit> units;
    for (std::size_t s = 0; s < plan_.sequences.size(); ++s) {
      const std::size_t frames = plan_.sequences[s].samples.size();
      const std::size_t framesOfUnit = layout_->bySequence() ? frames : 1;  // a sequence has at least one frame
      for (std::size_t f = 0; f < frames; f += framesOfUnit) units.push_back({s, f, framesOfUnit});
      summary_.frames += frames;
    }
    summary_.sequences = plan_.sequences.size();
    if (layout_->checksSamples(plan_)) {
      forUnits("checking", units, [&](const Unit& unit, const ReadSample& readSample) {
        for (std::size_t f = 0; f < unit.frames; ++f) {
          layout_->checkSample(plan_, readSample(unit.sequence, unit.firstFrame + f));
        }
      });
    }
    startFolder();
    forUnits("writing", units, [&](const Unit& unit, const ReadSample& readSample) {
      layout_->write(plan_, unit.sequence, unit.firstFrame, readSample, folder_);
    });
    const std::vector<std::string> warnings = layout_->finish(
        plan_, [this](std::size_t s, std::size_t f) { return store_.objects(plan_.sequences[s].samples[f]); }, folder_);
    summary_.warnings.insert(summary_.warnings.end(), warnings.begin(), warnings.end());
    folder_.write(kRecord, description());
    std::error_code ignored;
    fs::remove(folder_.path() / kUnfinished, ignored);
    syncFolder(folder_.path());
    return std::move(summary_);
  }

 private:
  // Sets plan_.classes, and warns of classes that have points but no counterpart.
  void chooseClasses() {
    const Ontology& source = plan_.manifest.ontology;
    Ontology target = source;
    if (!options_.classes.empty()) {
      target = readOntology(options_.classes);
    } else if (!options_.layout->labels.empty()) {
      target = readOntology(resourceFolder() / "labels" / (std::string(options_.layout->labels) + ".yaml"));
    }
    plan_.classes = ClassMap(source, std::move(target));
    const ScanTotals totals = totalsOf(plan_.manifest);
    std::vector<std::string> unmapped;  // names of classes
    for (const auto& [id, points] : totals.perClass) {
      const SemanticClass& c = *source.find(id);
      if (id != 0 && plan_.classes.targetId(id) == 0 && (c.thing || !options_.layout->boxesAlone))
        unmapped.push_back(c.name);
    }
    if (unmapped.empty()) return;
    summary_.warnings.push_back(fmt::format(
        "{} has no class for {}, so that their {} (--classes gives another ontology, whose aliases map classes)",
        plan_.classes.target().name, fmt::join(unmapped, ", "),
        options_.layout->boxesAlone ? "boxes are left out" : "points become unlabeled"));
  }

  // Sets plan_.sensors to the sensors that the user has named; if there are none, to as many as the layout allows.
  void chooseSensors() {
    std::vector<std::string> names;
    for (const SensorRecord& sensor : plan_.manifest.sensors) names.push_back(sensor.name);
    for (const std::string& name : options_.sensors) {
      if (std::ranges::find(names, name) != names.end()) continue;
      refuse(plan_, "has no sensor '{}'; it has {}", name, fmt::join(names, ", "));
    }
    for (const SensorRecord& sensor : plan_.manifest.sensors) {
      if (isChosen(sensor.name, options_.sensors)) plan_.sensors.push_back(&sensor);
    }
    if (!options_.layout->oneSensor || plan_.sensors.size() < 2) return;
    if (!options_.sensors.empty()) {
      throw InputError(
          fmt::format("{} stores the scans of only one sensor: give --sensor once", options_.layout->name));
    }
    plan_.sensors.erase(plan_.sensors.begin() + 1, plan_.sensors.end());
    summary_.warnings.push_back(
        fmt::format("{} stores the scans of only one sensor: writes those of '{}' (--sensor selects another)",
                    options_.layout->name, plan_.sensors.front()->name));
  }

  // Returns true if `chosen`, the names that the user has given, is empty or contains `name`.
  static bool isChosen(const std::string& name, const std::vector<std::string>& chosen) {
    return chosen.empty() || std::ranges::find(chosen, name) != chosen.end();
  }

  // Throws InputError unless each sample has exactly one revolution of each chosen sensor.
  void requireOneRevolution() const {
    for (const ExportSequence& sequence : plan_.sequences) {
      for (const std::size_t number : sequence.samples) {
        const SampleRecord& sample = plan_.manifest.samples[number];
        for (std::size_t s = 0; s < plan_.sensors.size(); ++s) {
          const std::size_t scans = revolutionsOf(plan_, sample, s).size();
          if (scans == 1) continue;
          refuse(plan_,
                 "{} has one scan of each sensor in a frame, but the sample {} has {} of '{}', "
                 "which turns at another rate than others or is one of a random choice: choose sensors with one scan "
                 "in each "
                 "sample by --sensor, generate with this sensor's period as `every_s`, or take "
                 "--to mcap, las or ply, which have all",
                 options_.layout->name, sample.key, scans, plan_.sensors[s]->name);
        }
      }
    }
  }

  // Returns true if the sample has no scan of the exported sensors, since its sequence drew another sensor.
  bool lacksSensors(const SampleRecord& sample) const {
    for (std::size_t s = 0; s < plan_.sensors.size(); ++s) {
      if (plan_.sensors[s]->choice.empty() || !revolutionsOf(plan_, sample, s).empty()) return false;
    }
    return true;
  }

  // Groups the samples of the chosen splits by sequence, and sorts each sequence by its frames. A sample whose key has
  // no frame is a sequence of its own.
  void chooseSequences() {
    const std::vector<SampleRecord>& samples = plan_.manifest.samples;
    std::set<std::string> splits;
    for (const SampleRecord& sample : samples) splits.insert(sample.split);
    for (const std::string& split : options_.splits) {
      if (splits.contains(split)) continue;
      refuse(plan_, "has no split '{}'; it has {}", split, fmt::join(splits, ", "));
    }
    std::map<std::string, std::size_t> indexOfSequence;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (!isChosen(samples[i].split, options_.splits) || lacksSensors(samples[i])) continue;
      const std::string name = partsOfKey(samples[i].key).sequence;
      const auto [entry, isNew] = indexOfSequence.emplace(name.empty() ? samples[i].key : name, plan_.sequences.size());
      if (isNew) plan_.sequences.push_back({.name = entry->first, .split = samples[i].split, .samples = {}});
      plan_.sequences[entry->second].samples.push_back(i);
    }
    for (ExportSequence& sequence : plan_.sequences) {
      std::ranges::stable_sort(sequence.samples, {},
                               [&](std::size_t sample) { return partsOfKey(samples[sample].key).order(); });
    }
  }

  std::string description() const {
    OrderedJson json{{"program", {{"name", "scanmill"}, {"version", kVersion}}},
                     {"layout", options_.layout->name},
                     {"dataset", plan_.manifest.name},
                     {"manifest_sha256", sha256(readFile(options_.dataset / kManifestName))},
                     {"classes", ontologyJson(plan_.classes.target())}};
    for (const SensorRecord* sensor : plan_.sensors) json["sensors"].push_back(sensor->name);
    for (const ExportSequence& sequence : plan_.sequences) {
      json["sequences"].push_back(
          {{"name", sequence.name}, {"split", sequence.split}, {"frames", sequence.samples.size()}});
    }
    return layOut(json) + "\n";
  }

  // Throws InputError unless the output folder is new or empty, or contains an export that may be replaced.
  void checkFolder() const {
    const fs::path& folder = folder_.path();
    if (!pathExists(folder)) return;
    if (!isFolder(folder)) throw InputError({folder.string()}, "is not a folder: name a folder with -o");
    const bool complete = pathExists(folder / kRecord);
    const bool unfinished = pathExists(folder / kUnfinished);
    if (unfinished) {
      const FolderLock free(folder, folder_.prepareFile(kLock));  // throws if another process writes
    }
    if (complete || unfinished) {
      if (options_.overwrite) return;
      throw InputError({folder.string()}, "has {} export: name another folder with -o, or replace it with --overwrite",
                       complete ? "a complete" : "an unfinished");
    }
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
      if (isLeftByKilledRun(entry.path())) continue;
      throw InputError({folder.string()}, "is not empty: name another folder with -o");
    }
  }

  // Returns true for the files that a run leaves behind if it is killed before it has described its export.
  static bool isLeftByKilledRun(const fs::path& path) {
    const std::string name = path.filename().string();
    return name == kLock || finalName(name) == kUnfinished;
  }

  // Locks the folder and removes an earlier export, its record first: if the program is then stopped, the folder does
  // not seem to be a complete export.
  void startFolder() {
    lock_ = std::make_unique<FolderLock>(folder_.path(), folder_.prepareFile(kLock));
    folder_.write(kUnfinished, description());
    if (options_.overwrite) fs::remove(folder_.path() / kRecord);
    std::vector<fs::path> obsolete;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_.path())) {
      const std::string name = entry.path().filename().string();
      const bool inUse = name == kLock || name == kUnfinished;
      if (!inUse && (options_.overwrite || isLeftByKilledRun(entry.path()))) obsolete.push_back(entry.path());
    }
    for (const fs::path& path : obsolete) fs::remove_all(path);
  }

  // Reads the scans of the chosen sensors in a frame, the objects and, if the layout needs them, the voxels.
  ExportSample read(std::size_t sequence, std::size_t frame) const {
    const std::size_t index = plan_.sequences[sequence].samples[frame];
    ExportSample sample{.record = &plan_.manifest.samples[index],
                        .sequence = sequence,
                        .frame = frame,
                        .scans = {},
                        .objects = store_.objects(index),
                        .voxels = {}};
    const std::vector<StoredScan> storedScans = store_.scans(index);
    for (std::size_t s = 0; s < plan_.sensors.size(); ++s) {
      for (const ScanRecord* record : revolutionsOf(plan_, *sample.record, s)) {
        const auto stored = std::ranges::find_if(storedScans, [&](const StoredScan& scan) {
          return scan.sensor == record->sensor && scan.revolution == record->revolution &&
                 scan.method == record->method;
        });
        if (stored == storedScans.end()) {
          refuse(plan_, "the sample {} has no scan of the sensor '{}'", sample.record->key, record->sensor);
        }
        sample.scans.push_back({record, plan_.sensors[s], s, store_.decode(index, *stored)});
      }
    }
    if (options_.layout->voxels) {
      const std::string& sensor = plan_.sensors.front()->name;
      if (const std::optional<std::string> bytes = store_.voxels(index, sensor))
        sample.voxels = decodeVoxels(*bytes, sample.record->key + "." + sensor + "." + std::string(kVoxelsSuffix));
    }
    return sample;
  }

  // Calls work(unit, readSample) for all units on several threads. readSample() also reports progress and obeys `stop`.
  template <class Work>
  void forUnits(const char* stage, const std::vector<Unit>& units, const Work& work) {
    std::uint64_t allFrames = 0;
    for (const Unit& unit : units) allFrames += unit.frames;
    std::uint64_t doneFrames = 0;
    std::mutex mutex;  // guards doneFrames and the callback
    const ReadSample readSample = [&](std::size_t sequence, std::size_t frame) {
      if (options_.stop != nullptr && *options_.stop) throw Error("stopped: --overwrite starts the export again");
      ExportSample sample = read(sequence, frame);
      const std::scoped_lock lock(mutex);
      doneFrames = std::min(doneFrames + 1, allFrames);  // a layout may read a frame again
      if (options_.progress) options_.progress(stage, doneFrames, allFrames);
      return sample;
    };
    parallelForEach(units.size(), 1, [&](std::size_t i) { work(units[i], readSample); });
  }

  const ExportOptions& options_;
  std::unique_ptr<ExportLayout> layout_;
  ScanStore store_;
  ExportFolder folder_;
  std::unique_ptr<FolderLock> lock_;  // locked while the folder is written
  ExportPlan plan_;
  ExportSummary summary_;
};

}  // namespace

ExportSummary exportDataset(const ExportOptions& options) {
  return Export(options).run();
}

}  // namespace scanmill
