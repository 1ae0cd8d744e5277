#include "dataset/scan_store.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/append_new.h"
#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "config/text.h"
#include "dataset/folder_contents.h"
#include "dataset/reader.h"
#include "dataset/recording.h"
#include "dataset/sample_names.h"
#include "dataset/shard_name.h"
#include "dataset/voxels.h"
#include "formats/cloud_file.h"
#include "formats/format.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

// Largest number of beams for which a beam table is filled: a damaged manifest may claim 65536 x 65536 beams, each of
// which takes 40 bytes.
constexpr std::size_t kMostFilledBeams = std::size_t{1} << 23;

// Returns the manifest that lists the shard, from the shard's folder or the folder above it; null if neither has such a
// manifest. Sets `folderOfManifest`.
std::shared_ptr<const Manifest> manifestOf(const fs::path& shard, fs::path& folderOfManifest) {
  const fs::path file = fs::absolute(shard).lexically_normal();
  for (const fs::path& folder : {file.parent_path(), file.parent_path().parent_path()}) {
    if (!fs::exists(folder / kManifestName)) continue;
    try {
      auto manifest = std::make_shared<const Manifest>(readManifest(folder));
      const std::string relative = file.lexically_relative(folder).generic_string();
      for (const ShardRecord& s : manifest->shards) {
        if (s.file != relative) continue;
        folderOfManifest = folder;
        return manifest;
      }
    } catch (const InputError& e) {
      warn(fmt::format("classes are shown without names: {}", e.what()));
    }
  }
  return nullptr;
}

// Returns true if a member with this name contains the scan.
bool isIn(const auto& scan, const MemberName& name) {
  return lowerCase(scan.sensor) == lowerCase(name.sensor) && scan.revolution == name.revolution &&
         lowerCase(scan.method) == lowerCase(name.method);
}

const ScanRecord* recordOf(const SampleRecord* sample, const MemberName& name) {
  if (sample == nullptr) return nullptr;
  const auto found = std::ranges::find_if(sample->scans, [&](const ScanRecord& r) { return isIn(r, name); });
  return found == sample->scans.end() ? nullptr : &*found;
}

// Returns the scan. Throws InputError if its rings and columns are those of far more beams than a sensor with so many
// points has, because images of all beams are made from scans.
Scan checked(Scan scan, const std::string& what) {
  constexpr std::uint64_t kUsual = 1 << 22, kBeamsPerPoint = 256;
  if (!knowsBeams(scan)) return scan;
  const PointKey extent = extentOf(scan);
  const std::uint64_t rings = std::max(scan.rings, extent.ring);
  const std::uint64_t columns = std::max(scan.columns, extent.column);
  if (rings * columns <= std::max<std::uint64_t>(kUsual, kBeamsPerPoint * scan.size())) return scan;
  throw InputError({what},
                   fmt::format("has {} points on beams of {} rings and {} columns, which no sensor has: correct "
                               "its columns 'ring' and 'column', or leave them out",
                               scan.size(), rings, columns));
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
        {path_.string()},
        fmt::format(
            "is neither the folder of a dataset nor a file of the kinds .tar, {}{}", scanSuffixes(),
            suffix == ".yaml" ? "; for a picture of a scene: `scanmill view SCENE.yaml --screenshot FILE.png`" : ""));
  }
  single_ = checked(formatBySuffix(suffix.substr(1)) != nullptr ? decodeMember(path_.string(), readFile(path_))
                                                                : scanOf(readCloud(path_), path_.string()),
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
  manifest_ = manifestOf(path_, folder_);
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
  const std::vector<SensorRecord>& known = manifest_->sensors;
  const auto found =
      std::ranges::find_if(known, [&](const SensorRecord& s) { return lowerCase(s.name) == lowerCase(sensor); });
  if (found == known.end()) return nullptr;
  const auto number = static_cast<std::size_t>(found - known.begin());
  {
    const std::lock_guard lock(mutex_);
    beams_.resize(known.size());
    if (beams_[number] != nullptr) return beamsAt(beams_[number], time);
  }
  // The table is filled without the lock, because the threads that fill it may take up other work, which may call this
  // function.
  auto table = std::make_shared<BeamTable>(found->beams);
  if (table->size() <= kMostFilledBeams) fillBeams(*table);
  const std::lock_guard lock(mutex_);
  if (beams_[number] == nullptr) beams_[number] = std::move(table);
  return beamsAt(beams_[number], time);
}

std::optional<std::size_t> ScanStore::find(const std::string& key) const {
  const auto found = byKey_.find(key);
  if (found == byKey_.end()) return std::nullopt;
  return found->second;
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

StoredScan ScanStore::scanOfRecorded(std::size_t sample, const std::string& sensor) const {
  if (!sensor.empty() && lowerCase(sensor) != lowerCase(recorded_->sensor)) {
    throw InputError({path_.string()}, fmt::format("has no sensor '{}'{}", sensor,
                                                   recorded_->sensor.empty() ? "" : "; it has " + recorded_->sensor));
  }
  return {recorded_->sensor, 0, "", {recorded_->scans.at(sample).points.string()}, nullptr};
}

std::vector<StoredScan> ScanStore::scans(std::size_t sample, const std::string& sensor) const {
  if (single_) return {{}};
  if (recorded_) return {scanOfRecorded(sample, sensor)};
  const Sample& stored = samples_.at(sample);
  std::vector<StoredScan> all;
  const bool manifestLists = stored.members.empty() && stored.record != nullptr;
  for (const std::string& member : manifestLists ? stored.record->members : stored.members) {
    const MemberName name = partsOfMember(member);
    if (formatBySuffix(name.suffix) == nullptr) continue;
    const auto known = std::ranges::find_if(all, [&](const StoredScan& s) { return isIn(s, name); });
    if (known != all.end()) {
      known->members.push_back(member);
      continue;
    }
    const ScanRecord* record = recordOf(stored.record, name);
    all.push_back({record ? record->sensor : name.sensor,
                   name.revolution,
                   record ? record->method : name.method,
                   {member},
                   record});
  }
  if (manifest_ != nullptr) {
    const auto errorOf = [&](const std::string& member) {
      const auto format = std::ranges::find(manifest_->formats, partsOfMember(member).suffix, &FormatRecord::suffix);
      return format == manifest_->formats.end() ? INFINITY : format->maxErrorMetres;
    };
    for (StoredScan& scan : all) std::ranges::stable_sort(scan.members, {}, errorOf);
  }
  const std::string where = shards_[stored.shard].file.string();
  if (all.empty()) {
    throw InputError({where}, fmt::format("has no scan of the sample '{}' in a known format", keys_[sample]));
  }
  if (sensor.empty()) return all;
  std::vector<std::string> sensors;
  for (const StoredScan& scan : all) appendNew({lowerCase(scan.sensor)}, sensors);
  std::erase_if(all, [&](const StoredScan& scan) { return lowerCase(scan.sensor) != lowerCase(sensor); });
  if (!all.empty()) return all;
  throw InputError({where}, fmt::format("the sample '{}' has no sensor '{}'; it has {}", keys_[sample], sensor,
                                        fmt::join(sensors, ", ")));
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
  requireUnchanged(samples_[sample], name, bytes);
  return bytes;
}

std::optional<SampleObjects> ScanStore::objects(std::size_t sample) const {
  if (single_ || manifest_ == nullptr) return {};
  const Sample& stored = samples_.at(sample);
  if (stored.record != nullptr && !stored.record->objects) return {};
  const std::string name = objectsMember(keys_.at(sample));
  const std::optional<std::string> bytes = bytesOf(sample, name);
  if (bytes) return parseObjects(*bytes, name, manifest_->ontology);
  if (stored.record == nullptr) return {};
  throw InputError({shards_[stored.shard].file.string()},
                   fmt::format("has no member {}, but the manifest lists it", name));
}

std::optional<std::string> ScanStore::voxels(std::size_t sample, const std::string& sensor) const {
  if (single_ || recorded_) return {};
  const std::string member = scans(sample, sensor).front().members.front();
  return bytesOf(sample, member.substr(0, member.rfind('.') + 1) + std::string(kVoxelsSuffix));
}

void ScanStore::requireUnchanged(const Sample& sample, const std::string& member, std::string_view bytes) const {
  if (digests_ == Digests::Ignored || sample.record == nullptr) return;
  const std::string stated = sample.record->xxh3Of(member);
  if (stated.empty() || xxh3(bytes) == stated) return;
  throw InputError({shards_[sample.shard].file.string()},
                   fmt::format("{} was changed since it was written: `scanmill regenerate {}` makes it again", member,
                               folder_.string()));
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
    return checked(readFolderScan(recorded), recorded.points.string());
  }
  const ShardIndex& index = shard(samples_.at(sample).shard);
  std::string failures;
  for (const std::string& name : scan.members) {
    const auto fail = [&](const std::string& what) { failures += (failures.empty() ? "" : "; ") + what; };
    const ShardMember* member = index.find(name);
    if (member == nullptr) {
      fail(index.damage().empty() ? fmt::format("has no member {}, but the manifest lists it", name)
                                  : name + " comes after the damage");
      continue;
    }
    const std::string bytes = index.read(*member);
    requireUnchanged(samples_[sample], name, bytes);
    try {
      return checked(decodeMember(name, bytes), name);
    } catch (const InputError& e) {
      fail(e.what());
    }
  }
  if (!index.damage().empty()) throw InputError(fmt::format("{}; {}", index.damage(), failures));
  throw InputError({index.file().string()}, failures);
}

ScanSource findScan(const std::filesystem::path& path, const std::string& sample, const std::string& sensor) {
  const ScanStore store(path);
  if (store.single()) {
    if (!sample.empty() || !sensor.empty()) {
      throw InputError({path.string()},
                       "is a single scan, so that --sample and --sensor have no effect: leave them out");
    }
    return {store.decode(0, {}), store.keys().front(), nullptr, {}};
  }
  std::size_t chosen = findKey(store.keys(), sample, path.string());
  const bool first = sensor.empty() && store.manifest() != nullptr;
  const std::string wanted = first ? store.manifest()->sensors.front().name : sensor;
  if (sample.empty()) {  // the first sample may have no scan of a sensor that turns slowly
    const auto isOfSensor = [&](const StoredScan& s) { return lowerCase(s.sensor) == lowerCase(wanted); };
    for (std::size_t i = chosen; i < store.keys().size() && !wanted.empty(); ++i) {
      if (std::ranges::none_of(store.scans(i), isOfSensor)) continue;
      chosen = i;
      break;
    }
  }
  const std::string& key = store.keys()[chosen];
  const StoredScan stored = store.scans(chosen, wanted).front();
  ScanSource source;
  source.scan = store.decode(chosen, stored);
  source.title = stored.sensor.empty() ? key : key + ", " + lowerCase(stored.sensor);
  source.beams = store.beams(stored.sensor, stored.record == nullptr ? 0 : stored.record->time);
  if (store.ontology() != nullptr) source.ontology = *store.ontology();
  return source;
}

}  // namespace scanmill
