#include "viewer/frames/stored_frames.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <set>

#include "base/append_new.h"
#include "base/error.h"
#include "base/file.h"
#include "base/parallel.h"
#include "config/resources.h"
#include "config/text.h"
#include "dataset/names.h"
#include "dataset/world_positions.h"
#include "pipeline/plan/dataset_plan.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

// Returns a label for each file or folder: its name or, if two have the same name, its path below the common folder.
std::vector<std::string> labelsOf(const std::vector<fs::path>& paths) {
  std::vector<std::string> names, absolutePaths;
  for (const fs::path& path : paths) {
    const fs::path normal = fs::absolute(path).lexically_normal();
    absolutePaths.push_back((normal.has_filename() ? normal : normal.parent_path()).string());
    names.push_back(fs::path(absolutePaths.back()).filename().string());
  }
  const auto countDistinct = [](const std::vector<std::string>& v) { return std::set(v.begin(), v.end()).size(); };
  if (countDistinct(names) == countDistinct(absolutePaths)) return names;
  fs::path folder = fs::path(absolutePaths.front()).parent_path();
  const auto isInFolder = [&](const std::string& path) {
    return *fs::path(path).parent_path().lexically_relative(folder).begin() != "..";
  };
  while (!std::ranges::all_of(absolutePaths, isInFolder)) folder = folder.parent_path();
  for (std::string& path : absolutePaths) path = fs::path(path).lexically_relative(folder).string();
  return absolutePaths;
}

// True if the names of sensors or methods differ at most in upper and lower case.
bool isSameName(const std::string& a, const std::string& b) {
  return lowerCase(a) == lowerCase(b);
}

// Returns a description of the first class that has different names in the two ontologies; empty if there is none.
std::string differenceOf(const Ontology& a, const Ontology& b) {
  const auto nameIn = [](const Ontology& ontology, std::uint16_t id) {
    const SemanticClass* found = ontology.find(id);
    return found == nullptr ? std::string("nothing") : found->name;
  };
  for (const Ontology* ontology : {&a, &b}) {
    for (const SemanticClass& c : ontology->classes) {
      const std::string nameA = nameIn(a, c.id), nameB = nameIn(b, c.id);
      if (nameA != nameB)
        return fmt::format("class {} is {} in '{}' and {} in '{}'", c.id, nameA, a.name, nameB, b.name);
    }
  }
  return {};
}

// True if the scan's points were transformed to the sensor's frame at the start of the revolution (deskewed) and the
// sensor moved. Then ranges from the beams' origins cannot be computed.
bool movedToStart(const Manifest* manifest, const ScanRecord* record) {
  return manifest != nullptr && manifest->deskewed && record != nullptr && record->worldFromSensor.size() > 1 &&
         record->worldFromSensor.front() != record->worldFromSensor.back();
}

// Returns the file whose path a dataset's manifest records; nothing if the file is not found. The path is relative to
// the pipeline's folder, which the manifest does not record, so each of pipelineFolders() is tried.
std::optional<fs::path> fileOf(const std::string& recordedPath, const fs::path& datasetFolder) {
  for (const fs::path& folder : pipelineFolders(datasetFolder)) {
    const fs::path file = fileOfSavedPath(recordedPath, folder);
    if (isFile(file)) return file;
  }
  return std::nullopt;
}

}  // namespace

std::optional<SceneChoice> sceneOf(const SequenceRecord* sequence, const fs::path& datasetFolder, double time,
                                   std::string& why) {
  constexpr const char* kAdvice = "give --scene FILE to see it";
  if (sequence == nullptr || sequence->sceneFile.empty()) {
    why = fmt::format("the manifest does not say which scene this is of: {}", kAdvice);
    return std::nullopt;
  }
  if (const auto file = fileOf(sequence->sceneFile, datasetFolder)) {
    return SceneChoice{.file = *file, .seed = sequence->seed, .time = sequence->moving ? time : 0};
  }
  why = fmt::format("the scene '{}' of the dataset is not found here: {}", sequence->sceneFile, kAdvice);
  return std::nullopt;
}

// Returns the points in the sensor's frame at the start of the revolution; empty if Scan::position is in this frame.
std::vector<Vec3f> placedAtStart(const Scan& scan, const ScanRecord& record, const BeamTable& beams, bool deskewed) {
  const WorldPositions world(scan, record, beams, deskewed);
  std::vector<Vec3f> placed;
  if (!world.moves()) return placed;
  const Pose startFromWorld = inverse(record.worldFromSensor.front());
  placed.reserve(scan.size());
  for (std::size_t i = 0; i < scan.size(); ++i) placed.emplace_back(startFromWorld * world.inWorld(i));
  return placed;
}

// A scan that is being loaded: its position in a store, and the data that have been read.
struct StoredFrames::Loading {
  const Store* store = nullptr;
  std::size_t sample = 0;  // index of the sample in the store
  StoredScan stored;
  ViewScan scan{};
  std::vector<std::string> problems{};
  bool loaded = false;  // true: the points could be read, even if there are problems
};

StoredFrames::StoredFrames(const ViewInput& input) : input_(input) {
  std::vector<fs::path> paths{input.path};
  paths.insert(paths.end(), input.over.begin(), input.over.end());
  const std::vector<std::string> labels = labelsOf(paths);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    stores_.push_back({.scans = std::make_unique<const ScanStore>(paths[i]), .label = labels[i]});
  }
  if (!input.reference.empty()) reference_ = std::make_unique<const ScanStore>(input.reference);
  checkJoins();
  chooseOntology();
  if (mainStore().manifest() == nullptr) return;
  for (const SampleRecord& s : mainStore().manifest()->samples) sequences_[partsOfKey(s.key).sequence].push_back(&s);
  for (auto& [name, samples] : sequences_) {
    std::ranges::stable_sort(samples, {}, [](const SampleRecord* sample) { return partsOfKey(sample->key).order(); });
  }
}

// Throws InputError if there is no sample, if the main store is a single scan but another store or the reference is
// not, or if the main store lacks the sensor that the user chooses.
void StoredFrames::checkJoins() const {
  const std::string where = input_.path.string();
  if (StoredFrames::keys().empty()) throw InputError({where}, "holds no sample");
  if (mainStore().single()) {
    if (!input_.sensor.empty()) {
      throw InputError({where}, "is a single scan: --sensor chooses from a dataset or a shard");
    }
    for (std::size_t i = 1; i < stores_.size(); ++i) {
      if (!stores_[i].scans->single()) {
        throw InputError({where},
                         "is a single scan and has no key to find in {}: give the dataset first, "
                         "and the scan with --over",
                         stores_[i].scans->path().string());
      }
    }
    if (reference_ != nullptr && !reference_->single()) {
      throw InputError({where},
                       "is a single scan and has no key to find in {}: its reference must be a single "
                       "scan too",
                       reference_->path().string());
    }
    return;
  }
  if (input_.sensor.empty()) return;
  const std::vector<std::string> sensors = mainStore().sensors();
  if (std::ranges::none_of(sensors, [&](const std::string& name) { return isSameName(name, input_.sensor); })) {
    throw InputError({where}, "has no sensor '{}'; it has {}", input_.sensor,
                     sensors.empty() ? "none with a name" : fmt::format("{}", fmt::join(sensors, ", ")));
  }
}

// Sets `ontology_` to the file that the user chooses or, without a choice, to the first ontology of a store. Then also
// sets Store::classDifference of each store whose classes differ.
void StoredFrames::chooseOntology() {
  if (!input_.ontology.empty()) {
    ontology_ = readOntology(input_.ontology);
    return;
  }
  std::string chosenLabel;
  for (Store& s : stores_) {
    if (s.scans->ontology() == nullptr) continue;
    if (!ontology_) {
      ontology_ = *s.scans->ontology();
      chosenLabel = s.label;
    }
    if (const std::string difference = differenceOf(*ontology_, *s.scans->ontology()); !difference.empty()) {
      s.classDifference = fmt::format("{} has other classes than {}, whose names and colours are shown: {}", s.label,
                                      chosenLabel, difference);
    }
  }
}

// Finds the scans of a sample in all stores. Adds a line to `problems` for each store that does not have the sample.
std::vector<StoredFrames::Loading> StoredFrames::findScans(const std::string& key,
                                                           std::vector<std::string>& problems) const {
  std::vector<Loading> scans;
  for (const Store& s : stores_) {
    const auto sample = s.scans->single() ? std::optional<std::size_t>(0) : s.scans->find(key);
    if (!sample) {
      problems.push_back(fmt::format("{} has no sample '{}'", s.scans->path().string(), key));
      continue;
    }
    try {
      for (StoredScan& scan : s.scans->scans(*sample, input_.sensor)) {
        scans.push_back({.store = &s, .sample = *sample, .stored = std::move(scan)});
      }
    } catch (const InputError& e) {
      problems.emplace_back(e.what());
    }
  }
  return scans;
}

// Names each scan after its sensor, its method if the scans have several methods, and its store if there are several
// stores or the sensor is unknown. Repeated names get a number.
void StoredFrames::nameScans(std::vector<Loading>& scans) const {
  std::set<std::string> methods;
  for (const Loading& l : scans) {
    if (!l.stored.method.empty()) methods.insert(l.stored.method);
  }
  std::set<std::string> usedNames;
  for (Loading& l : scans) {
    std::string name = l.stored.sensor;
    if (methods.size() > 1 && !l.stored.method.empty()) name += (name.empty() ? "" : ", ") + l.stored.method;
    if (name.empty()) {
      name = l.store->label;
    } else if (stores_.size() > 1) {
      name = l.store->label + ": " + name;
    }
    l.scan.name = name;
    for (int copy = 2; !usedNames.insert(l.scan.name).second; ++copy) l.scan.name = fmt::format("{} ({})", name, copy);
  }
}

// Sets the errors of a scan to the distances of its points from the reference's scan of the same sensor and revolution,
// preferably of the same method. Throws InputError if the reference has no such scan, or the scans cannot be compared.
void StoredFrames::addReferenceError(ViewScan& scan, const std::string& key) const {
  const auto sample = reference_->single() ? std::optional<std::size_t>(0) : reference_->find(key);
  if (!sample)
    throw InputError({reference_->path().string()}, fmt::format("the noise-free reference has no sample '{}'", key));
  const std::vector<StoredScan> references = reference_->scans(*sample, scan.sensor);
  const auto isSameRevolution = [&](const StoredScan& r) { return r.revolution == scan.revolution; };
  auto partner = std::ranges::find_if(
      references, [&](const StoredScan& r) { return isSameRevolution(r) && isSameName(r.method, scan.method); });
  if (partner == references.end()) partner = std::ranges::find_if(references, isSameRevolution);
  if (partner == references.end()) {
    throw InputError({reference_->path().string()},
                     fmt::format("the noise-free reference has no revolution {} of '{}' in the sample '{}'",
                                 scan.revolution, scan.sensor, key));
  }
  std::string why;
  scan.error = referenceErrors(scan.scan, reference_->decode(*sample, *partner), why);
  if (!why.empty()) throw InputError({reference_->path().string()}, why);
  scan.errorTitle = "distance to the reference (m)";
  scan.whyNoError = "no partner in the reference";
}

// Sets the errors of a scan: from the reference if there is one, otherwise from the column `range_true`, if the scan
// has it and was not moved to the start (movedToStart()). `sensorsDiffer`: the sample has scans of several sensors.
void StoredFrames::addError(Loading& loading, const std::string& key, bool sensorsDiffer) const {
  ViewScan& scan = loading.scan;
  if (reference_ == nullptr) {
    if (scan.scan[kRangeTrue].empty() || movedToStart(loading.store->scans->manifest(), loading.stored.record)) return;
    scan.error = rangeErrors(scan.scan, scan.beams.get());
    scan.errorTitle = "range error (m)";
    return;
  }
  if (reference_->single() && sensorsDiffer) {
    throw InputError({reference_->path().string()},
                     "the noise-free reference is a single scan: say with --sensor whose");
  }
  addReferenceError(scan, key);
}

// Reads the points of a scan that findScans() returned; sets pose, beams and errors. Adds failures to loading.problems.
void StoredFrames::loadScan(Loading& loading, const std::string& key, bool sensorsDiffer) const {
  ViewScan& scan = loading.scan;
  scan.sensor = loading.stored.sensor;
  scan.store = static_cast<std::size_t>(loading.store - stores_.data());
  scan.revolution = loading.stored.revolution;
  scan.method = loading.stored.method;
  if (const ScanRecord* record = loading.stored.record) {
    if (!record->worldFromSensor.empty()) scan.worldFromSensor = record->worldFromSensor.front();
    scan.time = record->time;
  }
  try {
    scan.scan = loading.store->scans->decode(loading.sample, loading.stored);
    loading.loaded = true;
    scan.beams = loading.store->scans->beams(scan.sensor, scan.time);
    if (scan.worldFromSensor && scan.beams != nullptr) {
      const bool deskewed = loading.store->scans->manifest()->deskewed;
      scan.placed = placedAtStart(scan.scan, *loading.stored.record, *scan.beams, deskewed);
    }
    addError(loading, key, sensorsDiffer);
  } catch (const std::exception& e) {
    loading.problems.push_back(reasonOf(e));
  }
}

ViewFrame StoredFrames::load(std::size_t frame) const {
  ViewFrame view;
  view.key = keys().at(frame);
  std::vector<Loading> scans = findScans(view.key, view.problems);
  nameScans(scans);
  const bool sensorsDiffer = !std::ranges::all_of(
      scans, [&](const Loading& l) { return isSameName(l.stored.sensor, scans.front().stored.sensor); });
  parallelForEach(scans.size(), 1, [&](std::size_t i) { loadScan(scans[i], view.key, sensorsDiffer); });
  for (Loading& l : scans) {
    if (std::string damage = l.loaded ? l.store->scans->damage(l.sample) : ""; !damage.empty()) {
      l.problems.push_back(fmt::format("{}; what lies before that is shown", damage));
    }
    if (!l.store->classDifference.empty() && !l.scan.scan[kLabel].empty()) {
      l.problems.push_back(l.store->classDifference);
    }
    appendNew(l.problems, view.problems);
    if (l.loaded) view.scans.push_back(std::move(l.scan));
  }
  try {
    if (auto list = mainStore().objects(frame)) {
      view.objects = std::move(list->objects);
      view.objectTime = list->time;
    }
  } catch (const InputError& e) {
    appendNew({e.what()}, view.problems);
  }
  view.worldFromVehicle = vehiclePose(view.key);
  return view;
}

// True if the user chooses the scan's sensor, or all sensors.
bool StoredFrames::isShown(const ScanRecord& scan) const {
  return input_.sensor.empty() || isSameName(scan.sensor, input_.sensor);
}

std::vector<Pose> StoredFrames::trajectory(std::size_t frame) const {
  const std::string& key = keys().at(frame);
  const std::string sequence = partsOfKey(key).sequence;
  const auto found = sequences_.find(sequence);
  std::vector<Pose> poses;
  if (found == sequences_.end()) return poses;
  for (const SampleRecord* sample : found->second) {
    // If keys have no frame numbers, the order of samples is unknown: only the shown sample is used.
    if (sequence.empty() && sample->key != key) continue;
    const auto scan = std::ranges::find_if(
        sample->scans, [&](const ScanRecord& s) { return isShown(s) && !s.worldFromSensor.empty(); });
    if (scan != sample->scans.end()) poses.push_back(scan->worldFromSensor.front());
  }
  return poses;
}

// Returns the first scan of the sample in the manifest; null if the sample is unknown or has no scan.
const ScanRecord* StoredFrames::firstScan(const std::string& key) const {
  const auto sequence = sequences_.find(partsOfKey(key).sequence);
  if (sequence == sequences_.end()) return nullptr;
  const auto sample = std::ranges::find(sequence->second, key, &SampleRecord::key);
  return sample == sequence->second.end() || (*sample)->scans.empty() ? nullptr : &(*sample)->scans.front();
}

std::optional<SceneChoice> StoredFrames::scene(std::size_t frame, std::string& why) const {
  const std::string& key = keys().at(frame);
  const ScanRecord* const scan = firstScan(key);
  const double time = scan == nullptr ? 0 : scan->time;
  const SequenceRecord* const sequence =
      mainStore().manifest() == nullptr ? nullptr : mainStore().manifest()->sequenceOf(key);
  if (!input_.scene.empty()) {
    return SceneChoice{input_.scene, input_.seed.value_or(sequence == nullptr ? 1 : sequence->seed), time};
  }
  return sceneOf(sequence, mainStore().folder(), time, why);
}

std::optional<std::filesystem::path> StoredFrames::vehicle() const {
  const Manifest* const manifest = mainStore().manifest();
  if (manifest == nullptr || manifest->sequences.empty() || manifest->sequences.front().vehicle.empty()) return {};
  return fileOf(manifest->sequences.front().vehicle, mainStore().folder());
}

// Returns the ego vehicle's pose at the start of the sample's first scan; nothing if the pose is unknown.
std::optional<Pose> StoredFrames::vehiclePose(const std::string& key) const {
  const ScanRecord* const scan = firstScan(key);
  if (scan == nullptr || scan->worldFromSensor.empty()) return {};
  const auto sensor = std::ranges::find(mainStore().manifest()->sensors, scan->sensor, &SensorRecord::name);
  if (sensor == mainStore().manifest()->sensors.end()) return {};
  return scan->worldFromSensor.front() * inverse(mountOf(*sensor, *scan));
}

std::vector<std::uint16_t> StoredFrames::classes() const {
  std::set<std::uint16_t> ids;
  for (const Store& s : stores_) {
    if (s.scans->manifest() == nullptr) return {};
    for (const SampleRecord& sample : s.scans->manifest()->samples) {
      for (const ScanRecord& scan : sample.scans) {
        if (!isShown(scan)) continue;
        for (const auto& [id, points] : scan.pointsPerClass) {
          if (points > 0) ids.insert(id);
        }
      }
    }
  }
  return {ids.begin(), ids.end()};
}

}  // namespace scanmill
