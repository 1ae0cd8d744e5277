#include "dataset/verify.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string_view>

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "dataset/names.h"
#include "dataset/objects.h"
#include "dataset/reader.h"
#include "dataset/voxels.h"
#include "formats/reasons_png.h"

namespace scanmill {

namespace fs = std::filesystem;

namespace {

// Checks one shard: its file, its members and its scans. run() is called once.
class ShardCheck {
 public:
  // `samples`: the shard's samples in the manifest; null: they are unknown, so that only the file is checked.
  ShardCheck(const fs::path& folder, const Manifest& manifest, std::uint32_t shard,
             const std::vector<const SampleRecord*>* samples)
      : manifest_(manifest),
        record_(manifest.shards[shard]),
        file_(folder / record_.file),
        described_(samples != nullptr) {
    result_.samples = described_ ? samples->size() : record_.samples;
    if (!described_) return;
    for (const SampleRecord* sample : *samples) {
      for (const std::string& member : sample->members) {
        expectedNames_.push_back(member);
        sampleOfMember_.emplace(member, sample);
      }
    }
  }

  // Returns the shard's numbers of samples, scans and points, and the problems; other fields of the result are 0.
  Verification run() {
    if (result_.samples != record_.samples) {
      problem("its entry states {} samples, but the manifest lists {}", record_.samples, result_.samples);
    }
    std::error_code failure;
    if (!fs::exists(fs::symlink_status(file_, failure))) {
      problem("is missing");
    } else if (!fs::is_regular_file(file_, failure)) {
      problem("is not a file");
    } else if (const std::uint64_t bytes = fs::file_size(file_, failure); bytes / 2 > record_.bytes) {
      // A file of more than twice the recorded bytes is not read, because it may be of any size.
      problem("has {} bytes, but the manifest says {}", bytes, record_.bytes);
    } else {
      checkBytes();
      if (described_) checkMembers();
    }
    return std::move(result_);
  }

 private:
  template <class... Values>
  void problem(fmt::format_string<Values...> text, Values&&... values) {
    result_.problems.push_back(fmt::format("{}: {}", record_.file, fmt::format(text, std::forward<Values>(values)...)));
  }

  // Returns the error's text without the shard's path at its start, because problem() adds the shard's name.
  std::string withoutPath(const InputError& error) const {
    const std::string text = error.what();
    const std::string prefix = file_.string() + ": ";
    return text.starts_with(prefix) ? text.substr(prefix.size()) : text;
  }

  // Compares the file's size and hash with the manifest.
  void checkBytes() {
    Sha256 hash;
    std::uint64_t bytes = 0;
    try {
      readBlocks(file_, [&](std::string_view block) {
        hash.add(block);
        bytes += block.size();
      });
    } catch (const InputError& error) {
      problem("{}", withoutPath(error));
      return;
    }
    if (bytes != record_.bytes) problem("has {} bytes, but the manifest says {}", bytes, record_.bytes);
    const std::string sha256 = hash.hex();
    if (sha256 != record_.sha256) problem("its SHA-256 is {}, but the manifest says {}", sha256, record_.sha256);
  }

  void checkMembers() {
    std::vector<std::string> names;  // names of the file's members, in order
    try {
      readTar(file_, [&](const std::string& name, std::string_view bytes) {
        names.push_back(name);
        const auto entry = sampleOfMember_.find(name);
        if (entry == sampleOfMember_.end()) return;  // checkNames() reports this member
        const std::size_t problemsBefore = result_.problems.size();
        checkMember(name, bytes, *entry->second);
        if (result_.problems.size() == problemsBefore) checkDigest(name, bytes, *entry->second);
      });
    } catch (const InputError& error) {
      problem("{}", withoutPath(error));
    }
    checkNames(names);
  }

  // Checks a member that the manifest lists. The name tells whether the member is a description, a list or a scan.
  void checkMember(const std::string& name, std::string_view bytes, const SampleRecord& sample) {
    if (name == sample.key + ".json") {
      const std::string difference = differenceOfSampleJson(bytes, sample);
      if (!difference.empty()) problem("{}: {}", name, difference);
      return;
    }
    const auto hasSuffix = [&](std::string_view suffix) { return name.ends_with("." + std::string(suffix)); };
    try {
      if (name == objectsMember(sample.key)) return checkObjects(name, bytes, sample);
      if (hasSuffix(kReasonsSuffix)) return checkReasons(name, bytes, sample);
      if (hasSuffix(kVoxelsSuffix)) return checkVoxels(name, bytes);
    } catch (const InputError& error) {
      return problem("{}", error.what());
    }
    try {
      checkDecoded(name, decodeMember(name, bytes), sample);
    } catch (const std::exception& error) {
      problem("{}", reasonOf(error));
    }
  }

  // Reports a member whose bytes differ from its hash in the manifest; such a member may decode and agree with the
  // manifest in all other respects.
  void checkDigest(const std::string& name, std::string_view bytes, const SampleRecord& sample) {
    const std::string stated = sample.xxh3Of(name);
    const std::string computed = xxh3(bytes);
    if (stated.empty() || computed == stated) return;
    problem("{}: was changed since it was written: its XXH3 is {}, but the manifest says {}", name, computed, stated);
  }

  // Returns the record of the scan to which a member belongs. If the sample has no such scan, reports the member and
  // returns null.
  const ScanRecord* recordOf(const std::string& name, std::string_view suffix, const SampleRecord& sample) {
    for (const ScanRecord& record : sample.scans) {
      if (name == sample.key + "." + memberSuffix(record, suffix)) return &record;
    }
    problem("{}: the manifest has no scan of this sensor and method", name);
    return nullptr;
  }

  // Checks a scan that was decoded from a member.
  void checkDecoded(const std::string& name, const Scan& scan, const SampleRecord& sample) {
    ++result_.scans;
    const std::string format = name.substr(name.rfind('.') + 1);
    const ScanRecord* const record = recordOf(name, format, sample);
    if (record == nullptr) return;
    result_.points += record->points;
    if (objects_ != nullptr && objects_->key == sample.key && countedSensors_.insert(record->sensor).second) {
      checkObjectPoints(name, scan, record->sensor);
    }
    const auto stated = std::ranges::find(manifest_.formats, format, &FormatRecord::suffix);
    const double maxError = stated == manifest_.formats.end() ? 0 : stated->maxErrorMetres;
    for (const std::string& text : checkScan(scan, *record, manifest_, maxError)) {
      problem("{}: {}", name, text);
    }
  }

  void checkVoxels(const std::string& name, std::string_view bytes) {
    const ScanVoxels voxels = decodeVoxels(bytes, name);
    const auto isKnown = [&](std::uint16_t id) { return id == 0 || manifest_.ontology.find(id) != nullptr; };
    const auto unknown = std::ranges::find_if_not(voxels.label, isKnown);
    if (unknown != voxels.label.end()) problem("{}: the ontology has no class {}", name, *unknown);
  }

  // Checks a list of objects and stores it in objects_. checkObjectPoints() later compares it with the sample's scans.
  void checkObjects(const std::string& name, std::string_view bytes, const SampleRecord& sample) {
    objects_ = nullptr;
    countedSensors_.clear();
    auto objects = std::make_unique<SampleObjects>(parseObjects(bytes, name, manifest_.ontology));
    if (objects->key != sample.key) {
      problem("{}: belongs to the sample '{}'", name, objects->key);
    } else if (objects->counts() != sample.objects) {
      problem("{}: its objects differ from the counts of the manifest", name);
    } else {
      objects_ = std::move(objects);
    }
  }

  // Compares the numbers of the scan's points on each object with objects_. Reports the first difference.
  void checkObjectPoints(const std::string& name, const Scan& scan, const std::string& sensor) {
    if (scan[kInstance].empty()) return;
    std::map<std::uint32_t, std::uint64_t> pointsOfObject;  // numbers of points, by instance id
    for (std::size_t i = 0; i < scan.size(); ++i) {
      if (scan[kInstance][i] != 0 && isFinite(scan.position[i])) ++pointsOfObject[scan[kInstance][i]];
    }
    for (const ObjectRecord& object : objects_->objects) {
      const auto view = std::ranges::find(object.views, sensor, &ObjectView::sensor);
      const std::uint64_t stated = view == object.views.end() ? 0 : view->points;
      const std::uint64_t counted = pointsOfObject[object.id];
      if (counted != stated) {
        problem("{}: has {} points of the object {}, but {} says {}", name, counted, object.id,
                objectsMember(objects_->key), stated);
        return;
      }
      pointsOfObject.erase(object.id);
    }
    // Whether an object's class is listed cannot be told from its points, which may have several classes.
    if (pointsOfObject.empty() || !manifest_.objectClasses.empty()) return;
    problem("{}: has points of the object {}, which is not in {}", name, pointsOfObject.begin()->first,
            objectsMember(objects_->key));
  }

  void checkReasons(const std::string& name, std::string_view bytes, const SampleRecord& sample) {
    const ScanRecord* const record = recordOf(name, kReasonsSuffix, sample);
    if (record == nullptr || countReasons(decodeReasons(bytes, name).reasonOfBeam) == record->beamsPerReason) return;
    problem("{}: the numbers of its pixels differ from the reasons in the manifest", name);
  }

  // Checks that the shard's members are exactly those of the manifest, in the same order. `names`: the members' names.
  void checkNames(const std::vector<std::string>& names) {
    if (names == expectedNames_) return;
    const std::size_t problemsBefore = result_.problems.size();
    std::set<std::string> distinctNames;
    for (const std::string& name : names) {
      if (!distinctNames.insert(name).second) problem("{}: is in the shard twice", name);
      if (!sampleOfMember_.contains(name)) problem("{}: is not in the manifest", name);
    }
    for (const std::string& name : expectedNames_) {
      if (!distinctNames.contains(name)) problem("{}: is missing", name);
    }
    if (result_.problems.size() > problemsBefore) return;
    // Both lists have the same names, so that they have the same length and differ in their order alone.
    const auto [actual, expected] = std::ranges::mismatch(names, expectedNames_);
    problem("the members are out of order: '{}' is in the place of '{}'", *actual, *expected);
  }

  const Manifest& manifest_;
  const ShardRecord& record_;
  fs::path file_;
  bool described_;
  std::vector<std::string> expectedNames_;                     // names of the members, in the order of the manifest
  std::map<std::string, const SampleRecord*> sampleOfMember_;  // records by name of the member
  std::unique_ptr<const SampleObjects> objects_;               // latest list of objects; null: it is damaged
  std::set<std::string> countedSensors_;                       // sensors whose points were compared with objects_
  Verification result_;
};

// Appends a line to `problems` for each contradiction within the manifest.
void checkManifest(const Manifest& manifest, std::vector<std::string>& problems) {
  const auto problem = [&]<class... Values>(fmt::format_string<Values...> text, Values&&... values) {
    problems.push_back(fmt::format("{}: {}", kManifestName, fmt::format(text, std::forward<Values>(values)...)));
  };
  if (sha256(manifest.pipelineText) != manifest.pipelineSha256) {
    problem("the SHA-256 of the pipeline's text differs from the stated one");
  }
  std::map<std::string, std::set<std::string>> splitsOfSequence;
  for (const SampleRecord& sample : manifest.samples) {
    const std::string sequence = partsOfKey(sample.key).sequence;
    std::set<std::string>& splits = splitsOfSequence[sequence];
    if (splits.insert(sample.split).second && splits.size() == 2 && !sequence.empty()) {
      problem("frames of sequence {} are in several splits", sequence);
    }
    const auto lists = [&](const std::string& member) {
      return std::ranges::find(sample.members, member) != sample.members.end();
    };
    if (sample.objects.has_value() != lists(objectsMember(sample.key))) {
      problem("sample {}: must have either both counts of objects and the member {}, or neither", sample.key,
              objectsMember(sample.key));
    }
    for (const ScanRecord& scan : sample.scans) {
      for (const FormatRecord& format : manifest.formats) {
        const std::string member = sample.key + "." + memberSuffix(scan, format.suffix);
        if (!lists(member)) problem("sample {} does not list the member {}", sample.key, member);
      }
      const std::string reasons = sample.key + "." + memberSuffix(scan, kReasonsSuffix);
      if (scan.beamsPerReason.empty() == lists(reasons)) {
        problem("sample {}: a scan must have either both reasons and the member {}, or neither", sample.key, reasons);
      }
    }
  }
}

// Reports files that look like part of the dataset but are not listed: any other file beside the shards of a split, and
// any tar or temporary file in the folder or below it. Other files in the dataset's folder, such as notes, are allowed.
void checkUnlistedFiles(const fs::path& folder, const Manifest& manifest, std::vector<std::string>& problems) {
  std::set<std::string> listed;
  std::set<std::string> splits;
  for (const ShardRecord& shard : manifest.shards) {
    listed.insert(shard.file);
    if (!shard.samplesSha256.empty()) listed.insert(samplesFileOf(shard.file));
    splits.insert(shard.split);
  }
  std::set<std::string> unlisted;
  for (auto file = fs::recursive_directory_iterator(folder); file != fs::recursive_directory_iterator(); ++file) {
    if (file->path() == folder / kHiddenName) {
      file.disable_recursion_pending();
      continue;
    }
    const fs::path relative = file->path().lexically_relative(folder);
    const std::string name = relative.generic_string();
    const bool besideShards = splits.contains(relative.parent_path().generic_string());
    const bool looksLikePart = name.ends_with(".tar") || name.find(".partial-") != std::string::npos;
    if ((besideShards || (looksLikePart && !file->is_directory())) && !listed.contains(name)) unlisted.insert(name);
  }
  for (const std::string& name : unlisted) problems.push_back(name + ": is not in the manifest");
}

// Returns what is wrong with a shard, as a predicate; empty if nothing is. `hashed`: also compares the SHA-256.
std::string faultOf(const fs::path& file, const ShardRecord& record, bool hashed) {
  std::error_code failure;
  if (!fs::is_regular_file(file, failure)) return "is missing";
  const std::uint64_t bytes = fs::file_size(file, failure);
  if (failure) return "cannot be read: " + failure.message();
  if (bytes != record.bytes) return fmt::format("has {} bytes, not {} as the manifest says", bytes, record.bytes);
  try {
    return !hashed || sha256OfFile(file) == record.sha256 ? "" : "is damaged: its SHA-256 differs from the manifest";
  } catch (const Error&) {
    return "cannot be read";
  }
}

}  // namespace

std::vector<std::string> shardFaults(const fs::path& folder, const Manifest& manifest, bool hashed) {
  std::vector<std::string> faults(manifest.shards.size());
  parallelForEach(faults.size(), 1, [&](std::size_t i) {
    faults[i] = faultOf(folder / manifest.shards[i].file, manifest.shards[i], hashed);
  });
  return faults;
}

Verification verifyDataset(const fs::path& folder, const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  std::map<std::uint32_t, std::string> undescribed;
  const Manifest manifest = readManifest(folder, undescribed);
  Verification total{.shards = manifest.shards.size()};
  if (const std::string problem = digestProblem(readFile(folder / kManifestName)); !problem.empty()) {
    total.problems.push_back(fmt::format("{}: {}", kManifestName, problem));
  }
  checkManifest(manifest, total.problems);
  for (std::size_t i = 1; i < manifest.files.size(); ++i) {
    if (manifest.files[i].file != manifest.files[i - 1].file) continue;
    warn("{}: some samples were made before {} changed, others after it (--resume=anyway)", folder.string(),
         manifest.files[i].file);
  }
  for (const auto& [shard, problem] : undescribed) total.problems.push_back(problem);

  std::vector<std::vector<const SampleRecord*>> samples(manifest.shards.size());
  for (const SampleRecord& sample : manifest.samples) {
    if (!sample.key.empty()) samples[sample.shard].push_back(&sample);
  }
  std::vector<Verification> parts(manifest.shards.size());
  std::mutex mutex;
  std::uint64_t done = 0;
  parallelForEach(parts.size(), 1, [&](std::size_t i) {
    const auto shard = static_cast<std::uint32_t>(i);
    parts[i] = ShardCheck(folder, manifest, shard, undescribed.contains(shard) ? nullptr : &samples[i]).run();
    if (!progress) return;
    const std::scoped_lock lock(mutex);
    progress(++done, parts.size());
  });
  for (std::uint32_t i = 0; i < parts.size(); ++i) {
    const Verification& part = parts[i];
    total.samples += part.samples;
    total.scans += part.scans;
    total.points += part.points;
    if (!part.problems.empty() || undescribed.contains(i)) total.damaged.push_back(i);
    total.problems.insert(total.problems.end(), part.problems.begin(), part.problems.end());
  }
  try {
    checkUnlistedFiles(folder, manifest, total.problems);
  } catch (const fs::filesystem_error& error) {
    total.problems.push_back(fmt::format("{}: cannot be listed: {}", error.path1().string(), error.code().message()));
  }
  return total;
}

}  // namespace scanmill
