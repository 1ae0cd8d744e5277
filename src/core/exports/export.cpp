#include "exports/export.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/folder_lock.h"
#include "base/hash.h"
#include "base/own_folder.h"
#include "base/parallel.h"
#include "config/resources.h"
#include "config/version.h"
#include "dataset/json_text.h"
#include "dataset/sample_names.h"
#include "dataset/scan_store.h"
#include "dataset/shard_name.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

constexpr const char* kRecord = "scanmill_export.json";       // description of a complete export
constexpr const char* kUnfinished = ".scanmill_export.json";  // description of an unfinished export
constexpr const char* kLock = ".scanmill_export.lock";

// A unit of work: a frame, or a complete sequence.
struct Unit {
  std::size_t sequence = 0;
  std::size_t frame = 0;
  std::size_t frames = 1;
};

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
      if (layout_->bySequence()) units.push_back({s, 0, frames});
      for (std::size_t f = 0; f < frames && !layout_->bySequence(); ++f) units.push_back({s, f, 1});
      summary_.frames += frames;
    }
    summary_.sequences = plan_.sequences.size();
    if (layout_->checksSamples(plan_)) {
      forUnits("checking", units, [&](const Unit& unit, const ReadSample& next) {
        for (std::size_t f = 0; f < unit.frames; ++f) {
          layout_->checkSample(plan_, next(unit.sequence, unit.frame + f));
        }
      });
    }
    startFolder();
    forUnits("writing", units, [&](const Unit& unit, const ReadSample& next) {
      layout_->write(plan_, unit.sequence, unit.frame, next, folder_);
    });
    const std::vector<std::string> warnings = layout_->finish(
        plan_, [this](std::size_t s, std::size_t f) { return store_.objects(plan_.sequences[s].samples[f]); }, folder_);
    summary_.warnings.insert(summary_.warnings.end(), warnings.begin(), warnings.end());
    folder_.write(kRecord, record());
    std::error_code ignored;
    fs::remove(folder_.path() / kUnfinished, ignored);
    syncFolder(folder_.path());
    return std::move(summary_);
  }

 private:
  void chooseClasses() {
    const Ontology& source = plan_.manifest.ontology;
    Ontology target = source;
    if (!options_.classes.empty()) {
      target = readOntology(options_.classes);
    } else if (!options_.layout->labels.empty()) {
      target = readOntology(resourceFolder() / "labels" / (std::string(options_.layout->labels) + ".yaml"));
    }
    plan_.classes = ClassMap(source, std::move(target));
    std::set<std::uint16_t> used;
    for (const SampleRecord& sample : plan_.manifest.samples) {
      for (const ScanRecord& scan : sample.scans) {
        for (const auto& [id, points] : scan.pointsPerClass) used.insert(id);
      }
    }
    std::vector<std::string> lost;
    for (const std::uint16_t id : used) {
      const SemanticClass& c = *source.find(id);
      if (id != 0 && plan_.classes.of(id) == 0 && (c.thing || !options_.layout->boxesAlone)) lost.push_back(c.name);
    }
    if (lost.empty()) return;
    summary_.warnings.push_back(fmt::format(
        "{} has no class for {}, so that their {} (--classes gives another ontology, whose aliases map classes)",
        plan_.classes.target().name, fmt::join(lost, ", "),
        options_.layout->boxesAlone ? "boxes are left out" : "points become unlabeled"));
  }

  void chooseSensors() {
    const std::vector<SensorRecord>& all = plan_.manifest.sensors;
    std::vector<std::string> names;
    for (const SensorRecord& sensor : all) names.push_back(sensor.name);
    for (const std::string& wanted : options_.sensors) {
      const auto found = std::ranges::find(names, wanted);
      if (found == names.end()) {
        throw InputError({options_.dataset.string()},
                         fmt::format("has no sensor '{}'; it has {}", wanted, fmt::join(names, ", ")));
      }
    }
    for (const SensorRecord& sensor : all) {
      const std::vector<std::string>& wanted = options_.sensors;
      if (wanted.empty() || std::ranges::find(wanted, sensor.name) != wanted.end()) {
        plan_.sensors.push_back(&sensor);
      }
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

  // Throws InputError if a sample has several revolutions of a sensor, or none.
  void requireOneRevolution() const {
    for (const ExportSequence& sequence : plan_.sequences) {
      for (const std::size_t number : sequence.samples) {
        const SampleRecord& sample = plan_.manifest.samples[number];
        for (std::size_t s = 0; s < plan_.sensors.size(); ++s) {
          const std::size_t scans = revolutionsOf(plan_, sample, s).size();
          if (scans == 1) continue;
          throw InputError({options_.dataset.string()},
                           fmt::format("{} has one scan of each sensor in a frame, but the sample {} has {} of '{}', "
                                       "which turns at another rate than others: choose sensors with one scan in each "
                                       "sample by --sensor, generate with this sensor's period as `every_s`, or take "
                                       "--to mcap, las, ply or npz, which have all",
                                       options_.layout->name, sample.key, scans, plan_.sensors[s]->name));
        }
      }
    }
  }

  void chooseSequences() {
    const std::vector<SampleRecord>& samples = plan_.manifest.samples;
    std::set<std::string> splits;
    for (const SampleRecord& sample : samples) splits.insert(sample.split);
    for (const std::string& wanted : options_.splits) {
      if (splits.contains(wanted)) continue;
      throw InputError({options_.dataset.string()},
                       fmt::format("has no split '{}'; it has {}", wanted, fmt::join(splits, ", ")));
    }
    std::map<std::string, std::size_t> known;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const bool skipped =
          !options_.splits.empty() && std::ranges::find(options_.splits, samples[i].split) == options_.splits.end();
      if (skipped) continue;
      const std::string name = partsOfKey(samples[i].key).sequence;
      const auto [sequence, isNew] = known.emplace(name.empty() ? samples[i].key : name, plan_.sequences.size());
      if (isNew) plan_.sequences.push_back({sequence->first, samples[i].split, {}});
      plan_.sequences[sequence->second].samples.push_back(i);
    }
    for (ExportSequence& sequence : plan_.sequences) {
      std::ranges::stable_sort(sequence.samples, [&](std::size_t a, std::size_t b) {
        const std::string frameA = partsOfKey(samples[a].key).frame;
        const std::string frameB = partsOfKey(samples[b].key).frame;
        return std::tuple(frameA.size(), frameA) < std::tuple(frameB.size(), frameB);
      });
    }
  }

  // Returns the description of this export.
  std::string record() const {
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

  // Throws InputError if the folder must not be written to.
  void checkFolder() const {
    const fs::path& folder = folder_.path();
    if (!pathExists(folder)) return;
    if (!isFolder(folder)) throw InputError({folder.string()}, "is not a folder: name a folder with -o");
    const bool complete = pathExists(folder / kRecord);
    const bool unfinished = pathExists(folder / kUnfinished);
    if (unfinished) {
      const FolderLock free(folder, folder_.prepareFile(kLock));  // names the process that writes, if there is one
    }
    if (complete || unfinished) {
      if (options_.overwrite) return;
      throw InputError({folder.string()},
                       fmt::format("has {} export: name another folder with -o, or replace it with --overwrite",
                                   complete ? "a complete" : "an unfinished"));
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

  // Locks the folder and removes an earlier export: its record first, so that the folder does not pass for a complete
  // export if the program is stopped.
  void startFolder() {
    lock_ = std::make_unique<FolderLock>(folder_.path(), folder_.prepareFile(kLock));
    folder_.write(kUnfinished, record());
    if (options_.overwrite) fs::remove(folder_.path() / kRecord);
    std::vector<fs::path> old;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_.path())) {
      const std::string name = entry.path().filename().string();
      const bool inUse = name == kLock || name == kUnfinished;
      if (!inUse && (options_.overwrite || isLeftByKilledRun(entry.path()))) old.push_back(entry.path());
    }
    for (const fs::path& path : old) fs::remove_all(path);
  }

  ExportSample read(std::size_t sequence, std::size_t frame) const {
    const std::size_t number = plan_.sequences[sequence].samples[frame];
    ExportSample sample{&plan_.manifest.samples[number], sequence, frame, {}, store_.objects(number), {}};
    std::vector<StoredScan> stored = store_.scans(number);
    for (std::size_t s = 0; s < plan_.sensors.size(); ++s) {
      for (const ScanRecord* record : revolutionsOf(plan_, *sample.record, s)) {
        const auto found = std::ranges::find_if(stored, [&](const StoredScan& scan) {
          return scan.sensor == record->sensor && scan.revolution == record->revolution &&
                 scan.method == record->method;
        });
        if (found == stored.end()) {
          throw InputError({options_.dataset.string()}, fmt::format("the sample {} has no scan of the sensor '{}'",
                                                                    sample.record->key, record->sensor));
        }
        sample.scans.push_back({record, plan_.sensors[s], s, store_.decode(number, *found)});
      }
    }
    if (layout_->readsVoxels()) {
      const std::string& sensor = plan_.sensors.front()->name;
      const std::optional<std::string> bytes = store_.voxels(number, sensor);
      if (bytes)
        sample.voxels = decodeVoxels(*bytes, sample.record->key + "." + sensor + "." + std::string(kVoxelsSuffix));
    }
    return sample;
  }

  // Calls work(unit, read) for all units, on several threads. A frame counts for the progress when it has been read.
  template <class Do>
  void forUnits(const char* stage, const std::vector<Unit>& units, const Do& work) {
    std::uint64_t all = 0;
    std::uint64_t done = 0;
    for (const Unit& unit : units) all += unit.frames;
    std::mutex mutex;
    const ReadSample readNext = [&](std::size_t sequence, std::size_t frame) {
      if (options_.stop != nullptr && *options_.stop) throw Error("stopped: --overwrite starts the export again");
      ExportSample sample = read(sequence, frame);
      const std::scoped_lock lock(mutex);
      done = std::min(done + 1, all);  // a layout may read a frame again
      if (options_.progress) options_.progress(stage, done, all);
      return sample;
    };
    parallelFor(units.size(), 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) work(units[i], readNext);
    });
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
