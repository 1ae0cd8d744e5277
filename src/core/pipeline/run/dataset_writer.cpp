#include "pipeline/run/dataset_writer.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/append_new.h"
#include "base/error.h"
#include "base/hash.h"
#include "dataset/folder_contents.h"
#include "dataset/json_text.h"
#include "dataset/names.h"
#include "pipeline/plan/shard_jobs.h"
#include "pipeline/run/generate.h"

namespace scanmill {

namespace {

// Throws InputError unless the sample that an earlier run has written has the key, time and poses of the frame. Poses
// are compared with a tolerance for the decimal digits of manifests.
void requireSame(const SampleRecord& written, const std::string& key, const Frame& frame) {
  constexpr double kTolerance = 1e-9;  // m, and components of unit quaternions
  const auto differ = [](const Pose& a, const Pose& b) {
    const Pose d = inverse(a) * b;
    return length(d.translation) > kTolerance || std::abs(std::abs(d.rotation.w) - 1) > kTolerance;
  };
  bool same = written.key == key && written.scans.size() == frame.shots.size();
  for (std::size_t i = 0; same && i < frame.shots.size(); ++i) {
    const Shot& shot = frame.shots[i];
    const ScanRecord& scan = written.scans[i];
    same = std::abs(scan.time - shot.time) <= kTolerance &&
           !differ(scan.worldFromSensor.front(), shot.worldFromSensor.front()) &&
           !differ(scan.worldFromSensor.back(), shot.worldFromSensor.back());
  }
  if (same) return;
  throw InputError(fmt::format(
      "the interrupted run has written the sample {} here, but the loop now gives {} at another pose or time: give the "
      "same frames in the same order, or start again by replacing the dataset",
      written.key, key));
}

}  // namespace

DatasetWriter::DatasetWriter(Options options) : options_(std::move(options)) {
  if (options_.use != FolderUse::Resume || isUnfinished(options_.folder)) {
    DatasetFolder::check(options_.folder, options_.use);
  }
}

std::uint32_t DatasetWriter::indexOf(const Sequence& sequence) {
  appendNew({sequence.key()}, sequences_);
  return static_cast<std::uint32_t>(std::ranges::find(sequences_, sequence.key()) - sequences_.begin());
}

std::uint32_t DatasetWriter::framesOf(const Sequence& sequence) const {
  const auto found = frames_.find(sequence.key());
  return found == frames_.end() ? 0 : found->second;
}

// Opens the folder, as soon as the plan of the first sample is known.
void DatasetWriter::open(const ShotSource& source) {
  if (folder_ != nullptr || whole_) return;
  plan_.hash = sha256(fmt::format("{} {}", datasetPlan(source.plan(), {}).hash, options_.shardSamples));
  if (options_.use == FolderUse::Resume) whole_ = wholeDatasetOf(plan_, options_.folder);
  if (!whole_) folder_ = std::make_unique<DatasetFolder>(options_.folder, options_.use, plan_);
}

DatasetWriter::Split& DatasetWriter::splitOf(const std::string& name) {
  const auto found = std::ranges::find(splits_, name, &Split::name);
  if (found != splits_.end()) return *found;
  if (!isSplitName(name)) throw InputError(fmt::format("'{}' cannot be the name of a split, such as train", name));
  return splits_.emplace_back(Split{.name = name, .open = nullptr, .complete = {}});
}

// Returns the next sample of the split as an earlier run has written it, and steps over it; null if the sample is new.
const SampleRecord* DatasetWriter::written(const Sequence& sequence) {
  if (whole_) {
    if (plan_.samples < whole_->samples.size()) return &whole_->samples[plan_.samples];
    throw InputError({options_.folder.string()},
                     "is complete with {} samples, but the loop gives more: replace the dataset", plan_.samples);
  }
  Split& split = splitOf(sequence.split);
  if (split.complete && split.passed == split.complete->numbers.size()) split.complete.reset();
  if (!split.complete && split.open == nullptr) {
    const std::string name = shardName(split.name, split.shards++);
    split.complete = folder_->findRecord(name, DatasetFolder::Check::Bytes);
    split.passed = 0;
    if (!split.complete) split.open = std::make_unique<OpenShard>(folder_->staging(), name, split.name);
  }
  return split.complete ? &split.complete->manifest.samples[split.passed++] : nullptr;
}

bool DatasetWriter::hasNext(const ShotSource& source, const Sequence& sequence, const Frame& frame,
                            const std::string& placed) {
  const std::string& split = splitOf_.try_emplace(sequence.key(), sequence.split).first->second;
  if (split != sequence.split) {
    throw InputError(fmt::format("the samples of the drive {} belong in one split, but it is '{}' and '{}'",
                                 sequence.key(), split, sequence.split));
  }
  open(source);
  placed_ = xxh3(placed);
  const SampleRecord* const earlier = written(sequence);
  if (earlier == nullptr) return false;
  const std::string key = sequence.key(frame.number);
  requireSame(*earlier, key, frame);
  if (!whole_) {
    const Split& shard = splitOf(sequence.split);
    if (shard.complete->placed.at(shard.passed - 1) != placed_) {
      throw InputError(fmt::format(
          "the interrupted run has written the sample {} with other poses or velocities of objects: give the "
          "same ones, or start again by replacing the dataset",
          key));
    }
  }
  if (whole_ ? plan_.samples == 0 : splitOf(sequence.split).passed == 1) {
    compared_ = earlier;
    return false;
  }
  ++plan_.samples;
  ++frames_[sequence.key()];
  return true;
}

void DatasetWriter::add(const ShotSource& source, const Sequence& sequence, MadeSample made) {
  ++frames_[sequence.key()];
  const std::uint64_t number = plan_.samples++;
  if (const SampleRecord* const earlier = std::exchange(compared_, nullptr)) {
    for (const Member& file : made.sample.files) {
      if (earlier->xxh3Of(made.sample.key + "." + file.suffix) == xxh3(file.bytes)) continue;
      throw InputError(
          fmt::format("the sample {} has other bytes than in the interrupted run, since a scene, an object "
                      "or the program has changed: start again by replacing the dataset",
                      earlier->key));
    }
    return;
  }
  const std::string classes = layOut(ontologyJson(made.scene->ontology));
  if (classes_.empty()) classes_ = classes;
  if (classes_ != classes) {
    throw InputError(
        fmt::format("{}: the scene has other classes than the scenes before: give all scenes of a dataset "
                    "the same `labels`",
                    made.sample.key));
  }
  Split& split = splitOf(sequence.split);
  split.open->writer.add(made.sample);
  DatasetPart& part = split.open->part;
  Manifest start = startManifest(source, plan_);
  start.sequences.front().name = sequence.key();
  start.sequences.front().trajectory = sequence.trajectoryName;
  const SequenceRecord record = start.sequences.front();
  if (part.numbers.empty()) part = {plan_.hash, {}, start};
  std::vector<SequenceRecord>& sequences = part.manifest.sequences;
  if (std::ranges::find(sequences, record) == sequences.end()) sequences.push_back(record);
  addItems(start.modelled, part.manifest.modelled);
  addFiles(start.files, part.manifest.files);
  addItems(made.scene->modelled, part.manifest.modelled);
  addFiles(made.scene->files, part.manifest.files);
  part.manifest.ontology = made.scene->ontology;
  part.manifest.objectClasses = made.scene->objectClasses;
  part.numbers.push_back(number);
  part.placed.push_back(placed_);
  account_ += made.account;
  if (part.numbers.size() == options_.shardSamples) close(split);
}

void DatasetWriter::close(Split& split) {
  ShardPart written = split.open->writer.finish();
  DatasetPart& part = split.open->part;
  part.manifest.shards = {std::move(written.shard)};
  part.manifest.samples = std::move(written.samples);
  folder_->storeRecord(part);
  split.open.reset();
}

Manifest DatasetWriter::finish() {
  if (plan_.samples == 0) throw Error("{}: the loop has given no sample", options_.folder.string());
  if (whole_) {
    if (plan_.samples == whole_->samples.size()) return std::move(*whole_);
    throw Error("{}: is complete with {} samples, but the loop has given {}: replace the dataset",
                options_.folder.string(), whole_->samples.size(), plan_.samples);
  }
  std::vector<DatasetPart> parts;
  for (Split& split : splits_) {
    if (split.complete && split.passed < split.complete->numbers.size()) {
      throw Error("{}: the loop has given fewer samples than the interrupted run: replace the dataset",
                  options_.folder.string());
    }
    if (split.open != nullptr) close(split);
    plan_.splits.push_back({split.name, split.shards});
  }
  for (const std::string& name : plan_.shards()) {
    std::optional<DatasetPart> part = folder_->findRecord(name, DatasetFolder::Check::Size);
    if (!part) throw Error("{} has vanished from {}", name, folder_->staging().string());
    parts.push_back(std::move(*part));
  }
  Manifest manifest = joinParts(plan_, std::move(parts));
  folder_->publish(manifest);
  for (const std::string& line : account_.warningTexts()) warn(line);
  folder_.reset();
  return manifest;
}

}  // namespace scanmill
