#include "dataset/scan_store.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "base/append_new.h"
#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "config/text.h"
#include "dataset/folder_contents.h"
#include "dataset/names.h"
#include "dataset/recording.h"
#include "dataset/voxels.h"
#include "formats/cloud_file.h"
#include "formats/format.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

// Largest number of beams for which a beam table is filled: a damaged manifest may claim 65536 x 65536 beams, each of
// which takes 40 bytes.
constexpr std::size_t kMostFilledBeams = std::size_t{1} << 23;

// Searches the shard's folder and the folder above it for the manifest that lists the shard. Returns the manifest and
// its folder; null if neither folder has such a manifest.
std::pair<std::shared_ptr<const Manifest>, fs::path> manifestOf(const fs::path& shard) {
  const fs::path file = fs::absolute(shard).lexically_normal();
  for (const fs::path& folder : {file.parent_path(), file.parent_path().parent_path()}) {
    if (!fs::exists(folder / kManifestName)) continue;
    try {
      auto manifest = std::make_shared<const Manifest>(readManifest(folder));
      const std::string relative = file.lexically_relative(folder).generic_string();
      const auto listed = std::ranges::find(manifest->shards, relative, &ShardRecord::file);
      if (listed != manifest->shards.end()) return {std::move(manifest), folder};
    } catch (const InputError& e) {
      warn("classes are shown without names: {}", e.what());
    }
  }
  return {};
}

// Returns true if a member with this name contains the scan. `scan`: a ScanRecord or a StoredScan.
bool isIn(const auto& scan, const MemberName& name) {
  return lowerCase(scan.sensor) == lowerCase(name.sensor) && scan.revolution == name.revolution &&
         lowerCase(scan.method) == lowerCase(name.method);
}

// Returns the record of the scan that the member contains; null if there is none.
const ScanRecord* recordOf(const SampleRecord* sample, const MemberName& name) {
  if (sample == nullptr) return nullptr;
  const auto record = std::ranges::find_if(sample->scans, [&](const ScanRecord& scan) { return isIn(scan, name); });
  return record == sample->scans.end() ? nullptr : &*record;
}

// Returns the scan. Throws an InputError that begins with `what` if the number of beams (rings * columns) exceeds both
// limits below: callers allocate a pixel for each beam, and a damaged file may claim any number.
Scan requirePlausibleBeams(Scan scan, const std::string& what) {
  constexpr std::uint64_t kAlwaysAllowed = 1 << 22;  // beams
  constexpr std::uint64_t kMostBeamsPerPoint = 256;
  if (!knowsBeams(scan)) return scan;
  const PointKey extent = extentOf(scan);
  const std::uint64_t rings = std::max(scan.rings, extent.ring);
  const std::uint64_t columns = std::max(scan.columns, extent.column);
  if (rings * columns <= std::max<std::uint64_t>(kAlwaysAllowed, kMostBeamsPerPoint * scan.size())) return scan;
  throw InputError({what},
                   "has {} points on beams of {} rings and {} columns, which no sensor has: correct "
                   "its columns 'ring' and 'column', or leave them out",
                   scan.size(), rings, columns);
}

}  // namespace

ScanStore::ScanStore(fs::path path, Digests digests) : digests_(digests), path_(std::move(path)) {
  std::error_code failure;
  const fs::file_status status = fs::status(path_, failure);
  if (!fs::exists(status)) {
    const bool absent = status.type() == fs::file_type::not_found;
    throw InputError({path_.string()}, absent ? "does not exist" : "cannot be read: " + failure.message());
  }
  if (fs::is_directory(status)) {
    openDataset();
  } else if (path_.extension() == ".tar") {
    openShard();
  } else {
    openSingle();
  }
}

void ScanStore::openSingle() {
  const std::string suffix = path_.extension().string();
  if (!isScan(path_)) {
    throw InputError(
        {path_.string()}, "is neither the folder of a dataset nor a file of the kinds .tar, {}{}", scanSuffixes(),
        suffix == ".yaml" ? "; for a picture of a scene: `scanmill view SCENE.yaml --screenshot FILE.png`" : "");
  }
  const bool hasFormat = formatBySuffix(suffix.substr(1)) != nullptr;
  single_ = requirePlausibleBeams(
      hasFormat ? decodeMember(path_.string(), readFile(path_)) : scanOf(readCloud(path_), path_.string()),
      path_.string());
  ontology_ = ontologyBeside(path_);
  keys_.push_back(path_.filename().string());
}

void ScanStore::openDataset() {
  if (!pathExists(path_ / kManifestName) && !recordingIn(path_)) recorded_ = scanFolderIn(path_);
  if (recorded_) {
    ontology_ = recorded_->ontology;
    for (const FolderScan& scan : recorded_->scans) addSample(scan.key, {});
    return;
  }
  requireDataset(path_,
                 ". Without it, these can be opened: a shard (.tar), a single scan, and a folder of recorded "
                 "scans of SemanticKITTI, KITTI or nuScenes, or with files " +
                     scanSuffixes());
  folder_ = path_;
  manifest_ = std::make_shared<const Manifest>(readManifest(path_));
  for (const ShardRecord& s : manifest_->shards) shards_.push_back({path_ / s.file, nullptr});
  for (const SampleRecord& s : manifest_->samples) addSample(s.key, {s.shard, {}, &s});
}

void ScanStore::openShard() {
  shards_.push_back({path_, std::make_unique<const ShardIndex>(path_)});
  std::tie(manifest_, folder_) = manifestOf(path_);
  for (const ShardMember& member : shards_.front().index->members()) {
    const MemberName name = partsOfMember(member.name);
    if (formatBySuffix(name.suffix) == nullptr) continue;
    if (!byKey_.contains(name.key)) addSample(name.key, {});
    samples_[byKey_.at(name.key)].members.push_back(member.name);
  }
  if (manifest_ == nullptr) return;
  for (const SampleRecord& s : manifest_->samples) {
    if (const auto index = find(s.key)) samples_[*index].record = &s;
  }
}

void ScanStore::addSample(const std::string& key, Sample sample) {
  byKey_.emplace(key, keys_.size());
  keys_.push_back(key);
  samples_.push_back(std::move(sample));
}

std::shared_ptr<const BeamTable> ScanStore::beams(const std::string& sensor, double time) const {
  if (manifest_ == nullptr) return nullptr;
  const std::vector<SensorRecord>& sensors = manifest_->sensors;
  const auto record =
      std::ranges::find_if(sensors, [&](const SensorRecord& s) { return lowerCase(s.name) == lowerCase(sensor); });
  if (record == sensors.end()) return nullptr;
  const auto sensorIndex = static_cast<std::size_t>(record - sensors.begin());
  {
    const std::lock_guard lock(mutex_);
    beams_.resize(sensors.size());
    if (beams_[sensorIndex] != nullptr) return beamsAt(beams_[sensorIndex], time);
  }
  // The table is filled without the lock: a thread that fills the table may meanwhile run other tasks, and a task that
  // calls this function would deadlock.
  auto table = std::make_shared<BeamTable>(record->beams);
  if (table->size() <= kMostFilledBeams) fillBeams(*table);
  const std::lock_guard lock(mutex_);
  if (beams_[sensorIndex] == nullptr) beams_[sensorIndex] = std::move(table);
  return beamsAt(beams_[sensorIndex], time);
}

std::optional<std::size_t> ScanStore::find(const std::string& key) const {
  const auto entry = byKey_.find(key);
  return entry == byKey_.end() ? std::nullopt : std::optional(entry->second);
}

std::vector<std::string> ScanStore::sensors() const {
  std::vector<std::string> names;
  if (recorded_ && !recorded_->sensor.empty()) names.push_back(recorded_->sensor);
  if (manifest_ != nullptr) {
    for (const SensorRecord& s : manifest_->sensors) appendNew({s.name}, names);
    return names;
  }
  for (const Sample& s : samples_) {
    for (const std::string& member : s.members) {
      if (const std::string name = partsOfMember(member).sensor; !name.empty()) appendNew({name}, names);
    }
  }
  return names;
}

const Ontology* ScanStore::ontology() const {
  if (manifest_ != nullptr) return &manifest_->ontology;
  return ontology_ ? &*ontology_ : nullptr;
}

std::vector<StoredScan> ScanStore::scansInShard(const Sample& sample) const {
  std::vector<StoredScan> scans;
  const bool manifestLists = sample.members.empty() && sample.record != nullptr;
  for (const std::string& member : manifestLists ? sample.record->members : sample.members) {
    const MemberName name = partsOfMember(member);
    if (formatBySuffix(name.suffix) == nullptr) continue;
    const auto sameScan = std::ranges::find_if(scans, [&](const StoredScan& scan) { return isIn(scan, name); });
    if (sameScan != scans.end()) {
      sameScan->members.push_back(member);
      continue;
    }
    const ScanRecord* const record = recordOf(sample.record, name);
    scans.push_back({.sensor = record ? record->sensor : name.sensor,
                     .revolution = name.revolution,
                     .method = record ? record->method : name.method,
                     .members = {member},
                     .record = record});
  }
  if (manifest_ == nullptr) return scans;
  const auto errorOf = [&](const std::string& member) {
    const auto format = std::ranges::find(manifest_->formats, partsOfMember(member).suffix, &FormatRecord::suffix);
    return format == manifest_->formats.end() ? INFINITY : format->maxErrorMetres;
  };
  for (StoredScan& scan : scans) std::ranges::stable_sort(scan.members, {}, errorOf);
  return scans;
}

std::vector<StoredScan> ScanStore::scans(std::size_t sample, const std::string& sensor) const {
  if (single_) return {{}};
  if (recorded_) {
    if (sensor.empty() || lowerCase(sensor) == lowerCase(recorded_->sensor)) {
      return {{.sensor = recorded_->sensor, .method = "", .members = {recorded_->scans.at(sample).points.string()}}};
    }
    throw InputError({path_.string()}, "has no sensor '{}'{}", sensor,
                     recorded_->sensor.empty() ? "" : "; it has " + recorded_->sensor);
  }
  std::vector<StoredScan> scans = scansInShard(samples_.at(sample));
  const std::string where = shards_[samples_[sample].shard].file.string();
  if (scans.empty()) {
    throw InputError({where}, "has no scan of the sample '{}' in a known format", keys_[sample]);
  }
  if (sensor.empty()) return scans;
  std::vector<std::string> sensors;
  for (const StoredScan& scan : scans) appendNew({lowerCase(scan.sensor)}, sensors);
  std::erase_if(scans, [&](const StoredScan& scan) { return lowerCase(scan.sensor) != lowerCase(sensor); });
  if (!scans.empty()) return scans;
  throw InputError({where}, "the sample '{}' has no sensor '{}'; it has {}", keys_[sample], sensor,
                   fmt::join(sensors, ", "));
}

const ShardIndex& ScanStore::shard(std::size_t number) const {
  const std::lock_guard lock(mutex_);
  Shard& shard = shards_[number];
  if (shard.index != nullptr) return *shard.index;
  if (!pathExists(shard.file)) {
    throw InputError({shard.file.string()},
                     "is missing, although the manifest lists it: copy it here, or generate the dataset again");
  }
  shard.index = std::make_unique<const ShardIndex>(shard.file);
  return *shard.index;
}

std::optional<std::string> ScanStore::bytesOf(std::size_t sample, const std::string& name) const {
  const ShardIndex& index = shard(samples_.at(sample).shard);
  const ShardMember* const member = index.find(name);
  if (member == nullptr) return {};
  std::string bytes = index.read(*member);
  const SampleRecord* const record = samples_[sample].record;
  if (digests_ == Digests::Ignored || record == nullptr) return bytes;
  const std::string stated = record->xxh3Of(name);
  if (stated.empty() || xxh3(bytes) == stated) return bytes;
  throw InputError({index.file().string()},
                   "{} was changed since it was written: `scanmill verify {}` says how to make it again", name,
                   folder_.string());
}

std::optional<SampleObjects> ScanStore::objects(std::size_t sample) const {
  if (single_ || manifest_ == nullptr) return {};
  const Sample& stored = samples_.at(sample);
  if (stored.record != nullptr && !stored.record->objects) return {};
  const std::string name = objectsMember(keys_.at(sample));
  const std::optional<std::string> bytes = bytesOf(sample, name);
  if (bytes) return parseObjects(*bytes, name, manifest_->ontology);
  if (stored.record == nullptr) return {};
  throw InputError({shards_[stored.shard].file.string()}, "has no member {}, but the manifest lists it", name);
}

std::optional<std::string> ScanStore::voxels(std::size_t sample, const std::string& sensor) const {
  if (single_ || recorded_) return {};
  const std::string member = scans(sample, sensor).front().members.front();
  return bytesOf(sample, member.substr(0, member.rfind('.') + 1) + std::string(kVoxelsSuffix));
}

std::string ScanStore::damage(std::size_t sample) const {
  if (single_ || recorded_) return {};
  const std::lock_guard lock(mutex_);
  const Shard& shard = shards_[samples_.at(sample).shard];
  return shard.index == nullptr ? std::string() : shard.index->damage();
}

Scan ScanStore::decode(std::size_t sample, const StoredScan& scan) const {
  if (single_) return *single_;
  if (recorded_) {
    const FolderScan& recorded = recorded_->scans.at(sample);
    return requirePlausibleBeams(readFolderScan(recorded), recorded.points.string());
  }
  const ShardIndex& index = shard(samples_.at(sample).shard);
  std::vector<std::string> problems;  // one for each member that cannot be decoded
  for (const std::string& name : scan.members) {
    const std::optional<std::string> bytes = bytesOf(sample, name);
    if (!bytes) {
      problems.push_back(index.damage().empty() ? fmt::format("has no member {}, but the manifest lists it", name)
                                                : name + " comes after the damage");
      continue;
    }
    try {
      return requirePlausibleBeams(decodeMember(name, *bytes), name);
    } catch (const InputError& e) {
      problems.emplace_back(e.what());
    }
  }
  const std::string problemText = fmt::format("{}", fmt::join(problems, "; "));
  if (!index.damage().empty()) throw InputError(fmt::format("{}; {}", index.damage(), problemText));
  throw InputError({index.file().string()}, problemText);
}

ScanSource findScan(const std::filesystem::path& path, const std::string& sample, const std::string& sensor) {
  const ScanStore store(path);
  if (store.single()) {
    if (!sample.empty() || !sensor.empty()) {
      throw InputError({path.string()},
                       "is a single scan, so that --sample and --sensor have no effect: leave them out");
    }
    return {.scan = store.decode(0, {}), .title = store.keys().front(), .beams = nullptr, .ontology = {}};
  }
  std::size_t sampleIndex = findKey(store.keys(), sample, path.string());
  const bool takesFirst = sensor.empty() && store.manifest() != nullptr;
  const std::string sensorName = takesFirst ? store.manifest()->sensors.front().name : sensor;
  if (sample.empty() && !sensorName.empty()) {
    // The middle sample may lack a scan of a sensor that turns slowly: take the next sample that has a scan, if any.
    const auto isOfSensor = [&](const StoredScan& s) { return lowerCase(s.sensor) == lowerCase(sensorName); };
    std::size_t i = sampleIndex;
    while (i < store.keys().size() && std::ranges::none_of(store.scans(i), isOfSensor)) ++i;
    if (i < store.keys().size()) sampleIndex = i;
  }
  const std::string& key = store.keys()[sampleIndex];
  const StoredScan stored = store.scans(sampleIndex, sensorName).front();
  ScanSource source;
  source.scan = store.decode(sampleIndex, stored);
  source.title = stored.sensor.empty() ? key : key + ", " + lowerCase(stored.sensor);
  source.beams = store.beams(stored.sensor, stored.record == nullptr ? 0 : stored.record->time);
  if (store.ontology() != nullptr) source.ontology = *store.ontology();
  return source;
}

}  // namespace scanmill
